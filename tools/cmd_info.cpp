// cairn info FILE
#include <algorithm>

#include "base/number_text.hpp"
#include "pipeline/info.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

// Lists longer than this are cut in the text form; --json has all of them.
constexpr std::size_t kLongestList = 8;

std::string one_line(const io::Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.as_string();
  if (value.is_number() && !value.is_integer()) return base::to_text(value.as_real());
  return value.dump(0);
}

bool is_scalar(const io::Json& value) {
  return !value.is_array() && !value.is_object();
}

// One member a line, nested ones indented.
void append(std::string& text, const std::string& name, const io::Json& value, std::size_t depth) {
  const std::string indent(2 * depth, ' ');
  if (value.is_object() && value.size() > 0) {
    text += indent + name + ":\n";
    for (const auto& [key, member] : value.as_object()) append(text, key, member, depth + 1);
    return;
  }
  if (value.is_array() && value.size() > 0 && !is_scalar(value.as_array()[0])) {
    text += indent + name + ": " + std::to_string(value.size()) + "\n";
    for (std::size_t i = 0; i < std::min(value.size(), kLongestList); ++i)
      text += indent + "  " + one_line(value.as_array()[i]) + "\n";
    if (value.size() > kLongestList) text += indent + "  ... (all of them with --json)\n";
    return;
  }
  text += indent + name + ": " + one_line(value) + "\n";
}

class InfoCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("file", file_, "File or folder to describe");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn info cloud.las --json");
    arguments.example("cairn info rock.glb");
  }

  CommandResult run(const Arguments& /*arguments*/, base::RunContext& /*ctx*/) override {
    CommandResult result;
    result.summary = pipeline::file_info(file_, options_);
    for (const auto& [name, value] : result.summary.as_object()) {
      if (name == "warnings") {
        for (const auto& warning : value.as_array()) result.text += "warning: " + warning.as_string() + "\n";
      } else {
        append(result.text, name, value, 0);
      }
    }
    return result;
  }

 private:
  std::filesystem::path file_;
  pipeline::InfoOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::InfoCommand)
