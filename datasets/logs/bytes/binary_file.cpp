#include "datasets/logs/bytes/binary_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/stop_point.h"
#include "datasets/data_error.h"

namespace credence::internal {
namespace {

constexpr std::uint64_t kReadAtOnce = std::uint64_t{1} << 20;

}  // namespace

BinaryFile::BinaryFile(const std::filesystem::path& file)
    : origin_{file, ""}, in_(open_data(file)), size_(std::filesystem::file_size(file)) {}

Bytes BinaryFile::view(std::uint64_t at, std::uint64_t count, std::string_view what) {
  if (at > size_ || count > size_ - at) {
    fail(at, fmt::format("{} of {} bytes begins here and the file ends at byte {}: cut off, or corrupted",
                         what, count, size_));
  }
  if (at < begin_ || at + count > end_) {
    stop_point();
    const std::uint64_t wanted = std::min(std::max(count, kReadAtOnce), size_ - at);
    if (buffer_.size() < wanted) buffer_.resize(static_cast<std::size_t>(wanted));
    begin_ = end_ = 0;
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(at));
    in_.read(reinterpret_cast<char*>(buffer_.data()), static_cast<std::streamsize>(wanted));
    if (static_cast<std::uint64_t>(in_.gcount()) != wanted) fail(at, "cannot be read");
    begin_ = at;
    end_ = at + wanted;
  }
  return Bytes(buffer_).subspan(static_cast<std::size_t>(at - begin_), static_cast<std::size_t>(count));
}

void BinaryFile::fail(std::uint64_t at, const std::string& problem) const {
  throw DataError(origin_.file, fmt::format("byte {}", at), problem);
}

}  // namespace credence::internal
