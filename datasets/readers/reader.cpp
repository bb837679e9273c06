#include "datasets/readers/reader.h"

#include "datasets/native/native_reader.h"
#include "datasets/readers/author_reader.h"
#include "datasets/readers/image_reader.h"
#include "datasets/text/text_table.h"
#include "models/find_row.h"

namespace slammot {
namespace {

constexpr ReaderRow kReaders[] = {
    {"native", "sequence.yaml, frames.csv, observations.csv", is_native, read_native},
    {"author", "groundTruth.txt starting 'numOfFrames:' (the thesis author's program)", is_author,
     read_author},
};

std::vector<ReaderRow>& table() {
  static std::vector<ReaderRow> rows(std::begin(kReaders), std::end(kReaders));
  return rows;
}

}  // namespace

std::span<const ReaderRow> reader_table() { return table(); }

void add_readers(std::span<const ReaderRow> rows) { add_rows(table(), rows, "reader"); }

Sequence read_sequence(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) throw InputError(folder, 0, "no such folder");
  require_utf8(folder, std::filesystem::absolute(folder).string());  // results name it
  std::string looked_for;
  for (const ReaderRow& row : reader_table()) {
    if (row.recognises(folder)) return row.read(folder);
    looked_for += (looked_for.empty() ? "" : "; nor ") + std::string(row.name) + ": " +
                  std::string(row.description);
  }
  if (const ImageReaderRow* images = find_image_reader(folder)) {
    throw InputError(folder, 0,
                     "images (" + std::string(images->name) + ") without measurements: " +
                         "they must be tracked first, by `slammot track`");
  }
  throw InputError(folder, 0, "not a sequence: neither " + looked_for);
}

}  // namespace slammot
