#include "datasets/readers/image_reader.h"

#include "datasets/native/native_reader.h"
#include "datasets/readers/euroc_images.h"
#include "datasets/readers/kitti_images.h"
#include "datasets/readers/kitti_raw_images.h"
#include "datasets/readers/plain_images.h"
#include "datasets/readers/tum_images.h"
#include "datasets/text/text_table.h"

namespace slammot {
namespace {

constexpr ImageReaderRow kImageReaders[] = {
    {"native", "sequence.yaml, frames.csv with a column `image`", is_native, read_native_images,
     add_native_others},
    {"euroc", "mav0/cam0/data.csv (EuRoC ASL)", is_euroc, read_euroc, add_euroc_pair},
    {"tum_rgbd", "rgb.txt (TUM RGB-D)", is_tum_rgbd, read_tum_rgbd, add_tum_depth},
    {"kitti_raw", "image_0N/timestamps.txt, calib_cam_to_cam.txt (KITTI raw)", is_kitti_raw,
     read_kitti_raw, add_kitti_raw_pair},
    {"kitti", "calib.txt, times.txt, image_N/ (KITTI odometry)", is_kitti, read_kitti,
     add_kitti_pair},
};

}  // namespace

std::span<const ImageReaderRow> image_reader_table() { return kImageReaders; }

const ImageReaderRow* find_image_reader(const std::filesystem::path& folder) {
  for (const ImageReaderRow& row : image_reader_table()) {
    if (row.recognises(folder)) return &row;
  }
  return nullptr;
}

Sequence read_images(const std::filesystem::path& folder) try {
  if (!std::filesystem::is_directory(folder)) throw InputError(folder, 0, "no such folder");
  require_utf8(folder, std::filesystem::absolute(folder).string());  // results name it
  const std::filesystem::directory_iterator listed(folder);          // throws where it may not be
  const ImageReaderRow* row = find_image_reader(folder);
  if (row) return row->read(folder);
  if (has_plain_images(folder)) {
    throw InputError(folder, 0,
                     "images without times and camera: state --rate HZ and --camera FILE.yaml");
  }
  std::string looked_for;
  for (const ImageReaderRow& known : image_reader_table()) {
    looked_for += (looked_for.empty() ? "" : "; nor ") + std::string(known.name) + ": " +
                  std::string(known.description);
  }
  throw InputError(folder, 0, "not a sequence of images: neither " + looked_for);
} catch (const std::filesystem::filesystem_error& error) {
  throw InputError(folder, 0, "cannot be read: " + error.code().message());
}

void add_other_images(Sequence& sequence) try {
  const ImageReaderRow* row = find_image_reader(sequence.folder);
  if (row != nullptr && row->add_others != nullptr) row->add_others(sequence);
} catch (const std::filesystem::filesystem_error& error) {
  throw InputError(sequence.folder, 0, "cannot be read: " + error.code().message());
}

std::vector<bool> images_present(const Sequence& sequence) {
  std::vector<bool> present;
  present.reserve(sequence.images.size());
  std::error_code ignored;
  for (const std::string& image : sequence.images) {
    present.push_back(std::filesystem::is_regular_file(sequence.folder / image, ignored));
  }
  return present;
}

}  // namespace slammot
