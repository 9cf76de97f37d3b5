#include "reports/render/html_text.h"

#include <gtest/gtest.h>

namespace credence::internal {
namespace {

TEST(EscapeHtml, LeavesNothingThatActs) {
  EXPECT_EQ(escape_html("<a href=\"x\" o='y'>&\n\x01"), "&lt;a href=&quot;x&quot; o=&#39;y&#39;&gt;&amp;  ");
  EXPECT_EQ(escape_html("σ² ≤ 1"), "σ² ≤ 1");
}

}  // namespace
}  // namespace credence::internal
