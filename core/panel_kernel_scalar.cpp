#include <cmath>

#include "core/panel_kernel.h"

namespace credence {
namespace {

struct Pack {
  struct D {
    double x[kPanelRows];
  };
  static constexpr int kTile = 1;

  template <typename Function>
  static D each(Function function) {
    D y;
    for (int i = 0; i < kPanelRows; ++i) y.x[i] = function(i);
    return y;
  }
  static D load(const double* p) {
    return each([=](int i) { return p[i]; });
  }
  static void store(double* p, const D& x) {
    for (int i = 0; i < kPanelRows; ++i) p[i] = x.x[i];
  }
  static D broadcast(double x) {
    return each([=](int) { return x; });
  }
  static D mul(const D& a, const D& b) {
    return each([&](int i) { return a.x[i] * b.x[i]; });
  }
  static D fma(const D& a, const D& b, const D& c) {
    return each([&](int i) { return std::fma(a.x[i], b.x[i], c.x[i]); });
  }
  static D fnma(const D& a, const D& b, const D& c) {
    return each([&](int i) { return std::fma(-a.x[i], b.x[i], c.x[i]); });
  }
  static bool not_negative(const D& x) {
    bool ok = true;
    for (const double value : x.x) ok = ok && value >= 0.0;
    return ok;
  }
  /// p[0], p[8], … p[56]
  static D strided(const double* p) {
    return each([=](int i) { return p[kPanelRows * i]; });
  }
};

#include "core/panel_kernel_body.inc"

}  // namespace

const PanelKernel* panel_kernel_scalar() {
  static constexpr PanelKernel kernel{&observe, &correct, &downdate};
  return &kernel;
}

}  // namespace credence
