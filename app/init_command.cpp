#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "app/commands.h"
#include "app/common_options.h"
#include "app/embedded_files.h"
#include "app/scenario_files.h"
#include "reports/render/atomic_file.h"

namespace credence::internal {
namespace {

namespace fs = std::filesystem;

/// The name that the examples have for what the user names.
constexpr std::string_view kExampleName = "my_filter";

struct InitOptions {
  std::string name;
  bool cpp = false, python = false, scenario = false, log = false;
  std::string from = "planar_loop";
};

struct Project {
  std::vector<std::pair<fs::path, std::string>> files;
  std::vector<std::string> next;  ///< what to type then
};

std::string replaced(std::string_view text, std::string_view name) {
  std::string out(text);
  for (std::size_t at = 0; (at = out.find(kExampleName, at)) != std::string::npos; at += name.size()) {
    out.replace(at, kExampleName.size(), name);
  }
  return out;
}

/// An example of the project under another name, as a folder of that name.
Project from_example(std::string_view example, const std::string& name) {
  Project project;
  for (const EmbeddedFile& file : embedded_files()) {
    if (!file.path.starts_with(example)) continue;
    project.files.emplace_back(fs::path(name) / replaced(file.path.substr(example.size()), name),
                               replaced(file.text, name));
  }
  return project;
}

Project scenario_project(const InitOptions& options) {
  const std::vector<OwnScenario> all = own_scenarios();
  const auto found = std::ranges::find(all, options.from, &OwnScenario::name);
  if (found == all.end()) {
    throw std::invalid_argument(
        fmt::format("--from {}: no such scenario; credence list scenarios names all", options.from));
  }
  const std::string file = options.name + ".toml";
  const std::string_view command = found->sweep ? "sweep" : "run";
  return {{{file, fmt::format("{}\n# All keys: credence help scenario\n", found->text)}},
          {fmt::format("credence {} {} --out out/{}", command, file, options.name)}};
}

Project make_project(const InitOptions& o) {
  if (o.scenario) return scenario_project(o);
  Project project = from_example(o.cpp      ? "examples/cpp_filter/"
                                 : o.python ? "examples/python_filter/"
                                            : "examples/log_filter/",
                                 o.name);
  project.next = {fmt::format("cd {}", o.name)};
  if (o.cpp) {
    project.next.insert(
        project.next.end(),
        {"cmake -S . -B build -DCMAKE_BUILD_TYPE=Release && cmake --build build", "build/" + o.name});
  } else if (o.python) {
    project.next.push_back(fmt::format("python3 {}.py", o.name));
  } else {
    project.next.insert(project.next.end(),
                        {fmt::format("python3 {}.py", o.name), "credence check logs --out out"});
  }
  return project;
}

/// A name of a CMake target, of a Python module, and of a file.
void require_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto accepted = [&](char c) { return letter(c) || (c >= '0' && c <= '9'); };
  if (!name.empty() && letter(name.front()) && std::ranges::all_of(name, accepted)) return;
  throw std::invalid_argument(
      fmt::format("init {}: a name has letters, digits and _, and begins with a letter", name));
}

int init(const InitOptions& options) {
  require_name(options.name);
  if (options.python && (options.name == "credence" || options.name == "numpy")) {
    throw std::invalid_argument(
        fmt::format("init {0}: {0}.py would be imported in the place of the module {0}; choose another name",
                    options.name));
  }
  const Project project = make_project(options);
  for (const auto& [file, text] : project.files) {
    if (fs::exists(file))
      throw std::invalid_argument(fmt::format("{}: is there already; nothing was written", file.string()));
  }
  for (const auto& [file, text] : project.files) {
    if (file.has_parent_path()) fs::create_directories(file.parent_path());
    write_new_file(file, text);
    fmt::print("{}\n", file.string());
  }
  fmt::print("\nNext:\n");
  for (const std::string& line : project.next) fmt::print("  {}\n", line);
  return kDone;
}

}  // namespace

void add_init_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("init", "writes a small project that builds and runs as it is");
  auto options = std::make_shared<InitOptions>();
  command->add_option("name", options->name, "of the project, its folder and its files")->required();
  auto* kind = command->add_option_group("kind", "what to begin with");
  kind->add_flag("--cpp", options->cpp, "a filter of your own in C++, with CMake");
  kind->add_flag("--python", options->python, "a filter of your own in Python");
  auto* scenario = kind->add_flag("--scenario", options->scenario, "a scenario file, NAME.toml");
  kind->add_flag("--log", options->log, "a filter in Python that writes logs for check");
  kind->require_option(1);
  command->add_option("--from", options->from, "with --scenario: which one it begins as")
      ->needs(scenario)
      ->capture_default_str();
  static constexpr const char* kExamples[] = {"credence init my_filter --cpp",
                                              "credence init my_filter --log",
                                              "credence init my_loop --scenario --from planar_loop"};
  command->footer(examples(kExamples));
  command->callback([options] { throw ExitStatus{init(*options)}; });
}

}  // namespace credence::internal
