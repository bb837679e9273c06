// A dense matrix whose shape changes every frame: it keeps its memory, so that a filter that has
// warmed up allocates nothing.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace slammot {

class GrowingMatrix {
 public:
  // Values are not kept, nor set.
  void resize(Eigen::Index rows, Eigen::Index cols) {
    rows_ = rows;
    cols_ = cols;
    grow();
  }

  // Values are kept, new ones not set.
  void add_columns(Eigen::Index count) {
    cols_ += count;
    grow();
  }

  Eigen::Map<Eigen::MatrixXd> operator*() { return {storage_.data(), rows_, cols_}; }
  Eigen::Map<const Eigen::MatrixXd> operator*() const { return {storage_.data(), rows_, cols_}; }
  Eigen::Index cols() const { return cols_; }

  void swap(GrowingMatrix& other) {
    storage_.swap(other.storage_);
    std::swap(rows_, other.rows_);
    std::swap(cols_, other.cols_);
  }

  // Drops the last columns.
  void keep_columns(Eigen::Index cols) { cols_ = cols; }

 private:
  void grow() {
    const auto size = static_cast<std::size_t>(rows_ * cols_);
    if (storage_.size() < size) storage_.resize(size + size / 2);
  }

  std::vector<double> storage_;
  Eigen::Index rows_ = 0, cols_ = 0;
};

}  // namespace slammot
