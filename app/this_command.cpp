#include "app/this_command.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "app/shell_word.h"

namespace credence::internal {

std::string this_command() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string words{std::istreambuf_iterator<char>(file), {}};
  std::string command;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find('\0', begin), words.size());
    std::string word = words.substr(begin, end - begin);
    // Where the program lies is of no interest to a reader elsewhere.
    if (begin == 0) word = std::filesystem::path(word).filename().string();
    if (!command.empty()) command += ' ';
    command += shell_word(word);
    begin = end + 1;
  }
  return command;
}

}  // namespace credence::internal
