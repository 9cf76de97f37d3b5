#include "reports/document/sweep/swept_values.h"

#include <cstdint>
#include <variant>

#include "core/nan.h"

namespace credence::internal {
namespace {

struct ScalarJson {
  template <class Value>
  Json operator()(const Value& value) const {
    return value;
  }
  Json operator()(const OtherValue&) const { return nullptr; }
};

}  // namespace

std::string swept_text(const ScalarValue& value) {
  const auto* text = std::get_if<std::string>(&value);
  return text != nullptr ? *text : value_text(value);
}

double swept_number(const ScalarValue& value) {
  if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
  if (const auto* d = std::get_if<double>(&value)) return *d;
  return kNaN;
}

Json swept_json(const SweepPlan& plan, const SweepPoint& point) {
  Json values;
  for (std::size_t i = 0; i < plan.axes.size(); ++i) {
    values[plan.axes[i].path] = std::visit(ScalarJson{}, point.values[i]);
  }
  return values;
}

}  // namespace credence::internal
