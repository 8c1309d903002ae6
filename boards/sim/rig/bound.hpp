// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "shared/geometry/vec.hpp"

/// The Cramér-Rao bound: no estimate without bias is better than the inverse of the Fisher information. The model is
/// differentiated by central differences at the truth, and the matrix inverted by Gauss-Jordan elimination: nothing
/// here is shared with an estimator.

namespace sc::sim {

class Fisher {
public:
    /// Steps of this many parameters about the truth; `size[i]` is a small step of parameter i (metres or radians).
    explicit Fisher(std::vector<double> size);

    /// What a sensor reads, as a function of the steps of `on` (in that order; all others are 0).
    using Model = std::function<Vec3(const std::vector<double>& steps)>;
    void observe(const std::vector<std::size_t>& on, const Vec3& sigma, const Model& model);
    /// The parameter itself is known so well from elsewhere.
    void know(std::size_t parameter, double sigma);
    /// Least covariance of the first `count` parameters.
    [[nodiscard]] std::vector<std::vector<double>> bound(std::size_t count) const;

private:
    std::vector<double> size_;
    std::vector<std::vector<double>> information_;
};

/// Least mean square of a place that follows from parameters: trace of J Σ Jᵀ, by differences again.
[[nodiscard]] double bound_of_place(const std::vector<std::vector<double>>& bound, const std::vector<double>& size,
                                    const Fisher::Model& place);

}  // namespace sc::sim
