// Reads a sequence of any known layout, recognised by its content. One row adds a layout.
#pragma once

#include <span>
#include <string_view>

#include "datasets/sequence/sequence.h"

namespace slammot {

struct ReaderRow {
  std::string_view name;
  std::string_view description;  // what it is recognised by
  bool (*recognises)(const std::filesystem::path& folder);
  Sequence (*read)(const std::filesystem::path& folder);
};
std::span<const ReaderRow> reader_table();

// Asked after those that are there; throws std::invalid_argument for a name that is taken.
void add_readers(std::span<const ReaderRow> rows);

// Throws InputError if no reader recognises the folder, or the one that does refuses it.
Sequence read_sequence(const std::filesystem::path& folder);

}  // namespace slammot
