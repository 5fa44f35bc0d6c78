#include "io/csv.hpp"

#include <cmath>

#include "fuzz/fuzz_text.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_text([&] {
    cairn::io::CsvReader table(cairn::testing::as_text(data, size), "fuzz", ',');
    while (table.next())
      for (std::size_t i = 0; i < table.header().size(); ++i) {
        static_cast<void>(table.text(i));
        static_cast<void>(cairn::testing::fuzz_text([&] {
          if (!std::isfinite(table.real(i))) std::abort();
        }));
      }
  });
}
