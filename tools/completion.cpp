#include "tools/completion.hpp"

#include "tools/registry.hpp"

namespace cairn::tools {

std::string bash_completion() {
  std::string names;
  for (const auto& entry : registry()) names += std::string(names.empty() ? "" : " ") + std::string(entry.name);
  return R"sh(# bash completion of cairn; load with: source <(cairn completion bash)
_cairn() {
  local word="${COMP_WORDS[COMP_CWORD]}"
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W ")sh" +
         names + R"sh( help completion --help --version" -- "$word"))
    return
  fi
  case "$word" in
    -*)
      local options
      options=$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --json-usage 2>/dev/null |
        sed -n 's/^ *"name": "\(.*\)",
         $ / --\1 / p') COMPREPLY = ($(compgen - W "$options --help" --"$word"));
  ;
    *) COMPREPLY=($(compgen -f -- "$word")) ;
    ;
    esac
}
complete -o filenames -F _cairn cairn
)sh";
}

}  // namespace cairn::tools
