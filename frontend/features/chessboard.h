// A chessboard in the first image fixes the world and its scale, as it did for the thesis's robot.
//
// World = the board: origin at the first inner corner, x along the rows of COLS corners, y along
// the columns, z into the board, so that a camera that looks at it has z < 0. Of the two numberings
// of a board the one is taken whose first corner is the nearer to the image's top left.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "datasets/sequence/sequence.h"

namespace slammot {

struct Chessboard {
  int columns = 0, rows = 0;  // of inner corners
  double pitch = 0.0;         // [m]
};

// `COLSxROWS,PITCH`, as in `9x6,0.04`. Throws std::invalid_argument.
Chessboard parse_chessboard(const std::string& text);

struct BoardView {
  std::vector<Eigen::Vector2d> pixels;     // of the inner corners, row by row
  std::vector<Eigen::Vector3d> positions;  // W [m]
  InitialCamera camera;                    // at rest; sigmas of pose as the pixels allow
};

// Nothing if the board is not found.
std::optional<BoardView> find_chessboard(const cv::Mat& image, const Camera& camera,
                                         const Chessboard& board);

// Of a board's corners the four outermost, by index: enough to fix seven degrees of freedom, and
// the other corners stay for the estimators to find.
std::vector<size_t> outer_corners(const Chessboard& board);

}  // namespace slammot
