// Writes the sample report, for work on the page: report_sample OUT.html
#include <fstream>
#include <iostream>

#include "report/html_report.hpp"
#include "report/sample_report.hpp"
#include "support/data.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: report_sample OUT.html\n";
    return 2;
  }
  std::ofstream out(argv[1], std::ios::binary);
  out << cairn::report::render_report(cairn::testing::sample_report(cairn::testing::test_data("report")));
  return out.flush() ? 0 : 1;
}
