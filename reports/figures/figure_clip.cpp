#include "reports/figures/figure_clip.h"

#include <algorithm>
#include <array>

namespace credence::internal {
namespace {

CanvasPoint between(const CanvasPoint& a, const CanvasPoint& b, double share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y)};
}

// The share of a segment that lies inside.
struct Share {
  double from = 0.0, to = 1.0;
};

// Cuts `share` at one side: the segment is `inside` of it at its start by that much and gains `gain` on its
// way.
void cut(Share& share, double inside, double gain) {
  if (gain > 0.0) share.from = std::max(share.from, -inside / gain);
  if (gain < 0.0) share.to = std::min(share.to, -inside / gain);
  if (gain == 0.0 && inside < 0.0) share.to = -1.0;
}

Share visible_share(const CanvasPoint& a, const CanvasPoint& b, const CanvasBox& box) {
  Share share;
  cut(share, a.x - box.left, b.x - a.x);
  cut(share, box.right - a.x, a.x - b.x);
  cut(share, a.y - box.top, b.y - a.y);
  cut(share, box.bottom - a.y, a.y - b.y);
  return share;
}

}  // namespace

bool is_inside(const CanvasPoint& point, const CanvasBox& box) {
  return point.x >= box.left && point.x <= box.right && point.y >= box.top && point.y <= box.bottom;
}

std::vector<CanvasPath> clip_line(const CanvasPath& line, const CanvasBox& box) {
  std::vector<CanvasPath> pieces;
  if (line.size() == 1 && is_inside(line[0], box)) pieces.push_back(line);
  bool open = false;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Share share = visible_share(line[i - 1], line[i], box);
    if (share.from > share.to) {
      open = false;
      continue;
    }
    if (!open) pieces.push_back({between(line[i - 1], line[i], share.from)});
    open = share.to == 1.0;
    pieces.back().push_back(open ? line[i] : between(line[i - 1], line[i], share.to));
  }
  return pieces;
}

CanvasPath clip_area(CanvasPath outline, const CanvasBox& box) {
  using Depth = double (*)(const CanvasPoint&, const CanvasBox&);  // inside of one side, by how much
  constexpr std::array<Depth, 4> sides{
      [](const CanvasPoint& p, const CanvasBox& b) { return p.x - b.left; },
      [](const CanvasPoint& p, const CanvasBox& b) { return b.right - p.x; },
      [](const CanvasPoint& p, const CanvasBox& b) { return p.y - b.top; },
      [](const CanvasPoint& p, const CanvasBox& b) { return b.bottom - p.y; }};
  for (const Depth depth : sides) {
    CanvasPath kept;
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const CanvasPoint& point = outline[i];
      const CanvasPoint& last = outline[i == 0 ? outline.size() - 1 : i - 1];
      const double here = depth(point, box);
      const double there = depth(last, box);
      if ((here >= 0.0) != (there >= 0.0)) kept.push_back(between(last, point, there / (there - here)));
      if (here >= 0.0) kept.push_back(point);
    }
    outline = std::move(kept);
  }
  return outline;
}

}  // namespace credence::internal
