#include "reports/render/latex_words.h"

#include <algorithm>
#include <array>
#include <utility>

namespace credence::internal {
namespace {

constexpr auto kCommands = std::to_array<std::pair<std::string_view, std::string_view>>({
    {"\\", "\\textbackslash{}"},
    {"{", "\\{"},
    {"}", "\\}"},
    {"&", "\\&"},
    {"%", "\\%"},
    {"$", "\\$"},
    {"#", "\\#"},
    {"_", "\\_"},
    {"~", "\\textasciitilde{}"},
    {"^", "\\textasciicircum{}"},
    {"<", "$<$"},
    {">", "$>$"},
    {"−", "$-$"},
    {"–", "--"},
    {"—", "---"},
    {"…", "\\dots{}"},
    {"×", "$\\times$"},
    {"±", "$\\pm$"},
    {"°", "\\textdegree{}"},
    {"²", "\\textsuperscript{2}"},
    {"µ", "\\textmu{}"},
    {"√", "$\\surd$"},
    {"χ", "$\\chi$"},
    {"σ", "$\\sigma$"},
    {"ν", "$\\nu$"},
    {"Δ", "$\\Delta$"},
    {"Φ", "$\\Phi$"},
    {"⁻¹", "\\textsuperscript{$-$1}"},
    {"ᵀ", "\\textsuperscript{T}"},
    {"“", "``"},
    {"”", "''"},
    {"≤", "$\\le$"},
    {"≥", "$\\ge$"},
    {"≫", "$\\gg$"},
    {"∞", "$\\infty$"},
    {"·", "$\\cdot$"},
    {"‖", "$\\|$"},
    {"▲", "$\\uparrow$"},
    {"▼", "$\\downarrow$"},
    {"³", "\\textsuperscript{3}"},
    {"⁺", "\\textsuperscript{+}"},
    {"⁻", "\\textsuperscript{$-$}"},
    {"x̂", "$\\hat{x}$"},
    {"α", "$\\alpha$"},
    {"θ", "$\\theta$"},
    {"π", "$\\pi$"},
    {"Σ", "$\\Sigma$"},
    {"|", "$|$"},
    {"≠", "$\\neq$"},
    {"≈", "$\\approx$"},
    {"→", "$\\rightarrow$"},
    {"¹", "$^1$"},
    {"½", "$\\frac12$"},
    {"β", "$\\beta$"},
    {"γ", "$\\gamma$"},
    {"δ", "$\\delta$"},
    {"ε", "$\\varepsilon$"},
    {"λ", "$\\lambda$"},
    {"μ", "$\\mu$"},
    {"ρ", "$\\rho$"},
    {"τ", "$\\tau$"},
    {"φ", "$\\varphi$"},
    {"ω", "$\\omega$"},
});

}  // namespace

std::string_view take_latex(std::string_view& text) {
  const auto* const known =
      std::ranges::find_if(kCommands, [&](const auto& command) { return text.starts_with(command.first); });
  const std::string_view taken = known == kCommands.end() ? text.substr(0, 1) : known->second;
  text.remove_prefix(known == kCommands.end() ? 1 : known->first.size());
  return taken;
}

std::string latex_words(std::string_view words) {
  std::string latex;
  while (!words.empty()) latex += take_latex(words);
  return latex;
}

}  // namespace credence::internal
