#pragma once

#include <span>
#include <vector>

#include "core/models/linear_model.h"

namespace credence::internal {

/// Whether a filter that assumes `assumed` knows F and H of the truth; its error then depends on x no more.
bool knows_dynamics(const LinearModel& truth, const LinearModel& assumed);
bool knows_dynamics(std::span<const LinearModel> truth, std::span<const LinearModel> assumed);

/// The linear models of the error e = x − x̂ of a filter with F̂ and Ĥ in a world with F and H, that starts at
/// x̂_0 = 0, x_0 = e_0:
///
///   [e; x]⁺ = [F̂, F − F̂; 0, F] [e; x] + [G; G] v,   ν = [Ĥ, H − Ĥ] [e; x] + w,   P0 → [P0, P0; P0, P0].
///
/// The update e − K ν, x is that of the gain [K; 0]. Where the filter knows F and H it is `truth` itself,
/// whose states are e alone. Both models have the same n and m. One model for each step of a period: [e; x]
/// in all of them where the filter errs in any.
std::vector<LinearModel> error_models(std::span<const LinearModel> truth,
                                      std::span<const LinearModel> assumed);

/// A matrix of n rows with zeros below (`rows` in all) or, of n columns, with zeros behind (`columns`).
Matrix padded(const Matrix& matrix, Index rows, Index columns);

}  // namespace credence::internal
