// Writes a sample report, for work on the page and for the browser's test: report_sample full|hostile|tiny OUT.html
#include <fstream>
#include <iostream>
#include <string>

#include "report/html_report.hpp"
#include "support/data.hpp"
#include "support/sample_report.hpp"

int main(int argc, char** argv) {
  const std::string kind = argc == 3 ? argv[1] : "";
  cairn::report::ReportData data;
  if (kind == "full") {
    data = cairn::testing::sample_report(cairn::testing::test_data("report"));
  } else if (kind == "hostile") {
    data = cairn::testing::hostile_report();
  } else if (kind == "tiny") {
    data = cairn::testing::tiny_report();
  } else {
    std::cerr << "usage: report_sample full|hostile|tiny OUT.html\n";
    return 2;
  }
  std::ofstream out(argv[2], std::ios::binary);
  out << cairn::report::render_report(data);
  return out.flush() ? 0 : 1;
}
