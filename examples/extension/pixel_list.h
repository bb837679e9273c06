// A reader and its row.
#pragma once

#include <slammot/datasets/readers/reader.h>
#include <slammot/datasets/sequence/sha256.h>
#include <slammot/datasets/text/text_table.h>

namespace slammot {

// `pixels.txt`: rows `timestamp track u v` by time, then by track, from one camera.
inline bool is_pixel_list(const std::filesystem::path& folder) {
  return std::filesystem::is_regular_file(folder / "pixels.txt");
}

inline Sequence read_pixel_list(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "pixels.txt";
  const std::string text = read_text_file(file);
  Sequence sequence;
  sequence.name = folder.filename().string();
  sequence.folder = folder;
  sequence.camera = {640, 480, 385.0, 385.0, 319.5, 239.5, PinholeLens{}};
  TextTable table(file, text);
  while (table.next_blank_row(4)) {
    const double time = table.real(0);
    const Observation z{table.count(1), {table.real(2), table.real(3)}};
    std::vector<Frame>& frames = sequence.frames;
    if (frames.empty() || time > frames.back().timestamp) {
      frames.push_back({static_cast<int>(frames.size()), time, {}, {}});
    } else if (time < frames.back().timestamp ||
               z.track <= frames.back().observations.back().track) {
      table.refuse("rows must be ordered by time, then by track");
    }
    frames.back().observations.push_back(z);
  }
  if (sequence.frames.empty()) throw InputError(file, 0, "no measurements");
  sequence.truth.resize(sequence.frames.size());
  Sha256 hash;
  hash.add(text);
  sequence.sha256 = hash.hex();
  return sequence;
}

constexpr ReaderRow kPixelList{"pixel_list", "pixels.txt", is_pixel_list, read_pixel_list};

}  // namespace slammot
