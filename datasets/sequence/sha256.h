// SHA-256 (FIPS 180-4), to name the input of a run by its content.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace slammot {

class Sha256 {
 public:
  void add(std::string_view bytes);
  std::string hex() const;  // of everything added so far, 64 lower-case digits

 private:
  void add_block(const unsigned char* block);
  void finish();

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<unsigned char, 64> pending_{};
  std::uint64_t bytes_ = 0;
};

}  // namespace slammot
