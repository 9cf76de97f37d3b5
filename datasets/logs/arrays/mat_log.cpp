#include "datasets/logs/arrays/mat_log.h"

#include "datasets/logs/arrays/array_log.h"
#include "datasets/logs/arrays/mat_arrays.h"

namespace credence::internal {
namespace {

class MatArrayFile final : public ArrayFile {
 public:
  explicit MatArrayFile(const std::filesystem::path& file)
      : path_(file), read_(read_mat_arrays(file, is_log_array)) {
    for (const MatArray& array : read_) {
      shapes_.push_back({array.name, array.is_read ? "numbers" : "not read", array.dims});
    }
  }

  const std::filesystem::path& path() const override { return path_; }
  const std::vector<ArrayShape>& arrays() const override { return shapes_; }

  void read(std::size_t i, std::uint64_t first, std::uint64_t count, std::vector<double>& out) override {
    out.resize(static_cast<std::size_t>(count));
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] = read_[i].numbers[static_cast<std::size_t>(column_major_place(shapes_[i].dims, first + k))];
    }
  }

 private:
  std::filesystem::path path_;
  std::vector<MatArray> read_;
  std::vector<ArrayShape> shapes_;
};

}  // namespace

LogFormat mat_format() {
  return {.name = "mat",
          .title = "MATLAB arrays",
          .extensions = ".mat",
          .recognises = [](std::string_view beginning,
                           const std::filesystem::path&) { return begins_as_mat(beginning); },
          .list = [](const std::filesystem::path& file) { return list_arrays(MatArrayFile(file)); },
          .read =
              [](const std::filesystem::path& file, const LogReadOptions&, LogSink& sink) {
                MatArrayFile arrays(file);
                read_arrays(arrays, sink);
                sink.advance(static_cast<std::int64_t>(std::filesystem::file_size(file)));
              }};
}

}  // namespace credence::internal
