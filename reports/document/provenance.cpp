#include "reports/document/provenance.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <charconv>
#include <cstdlib>
#include <ctime>
#include <string_view>

#include "analysis/studies/machine.h"
#include "core/version.h"

namespace credence::internal {
namespace {

std::time_t moment() {
  if (const char* fixed = std::getenv("SOURCE_DATE_EPOCH"); fixed != nullptr) {
    const std::string_view digits(fixed);
    std::time_t seconds = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), seconds);
    if (error == std::errc() && end == digits.data() + digits.size()) return seconds;
  }
  return std::time(nullptr);
}

std::string utc_text(std::time_t seconds) {
  std::tm parts{};
  if (gmtime_r(&seconds, &parts) == nullptr) return {};
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02}:{:02}", parts.tm_year + 1900, parts.tm_mon + 1,
                     parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec);
}

std::string machine_text() {
  const MachineDescription machine = describe_machine();
  utsname system{};
  const bool named = uname(&system) == 0;
  return fmt::format("{}, {} threads, {}{}", machine.processor, machine.processors, machine.instruction_set,
                     named ? fmt::format(", {} {}", system.sysname, system.machine) : "");
}

}  // namespace

Provenance make_provenance(std::string command) {
  return {.version = std::string(version()),
          .commit = std::string(credence::commit()),
          .command = std::move(command),
          .date = utc_text(moment()),
          .machine = machine_text()};
}

std::vector<std::pair<std::string, std::string>> provenance_facts(const Provenance& p) {
  std::vector<std::pair<std::string, std::string>> facts;
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) facts.emplace_back(name, value);
  };
  add("version", p.version.empty() ? "" : "Credence " + p.version);
  add("commit", p.commit);
  add("command", p.command);
  add("date", p.date.empty() ? "" : p.date + " UTC");
  add("machine", p.machine);
  return facts;
}

}  // namespace credence::internal
