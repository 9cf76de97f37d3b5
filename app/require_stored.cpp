#include "app/require_stored.h"

#include <fmt/format.h>

#include "montecarlo/engine/result_store.h"

namespace credence::internal {

void require_stored(const std::filesystem::path& directory) {
  if (ResultStore::exists(directory)) return;
  throw StoreError(fmt::format("{}: the stored results were moved or removed while the report was written",
                               directory.string()));
}

}  // namespace credence::internal
