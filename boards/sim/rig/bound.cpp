// SPDX-License-Identifier: Apache-2.0
#include "boards/sim/rig/bound.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace sc::sim {
namespace {

/// d model / d step, by central differences.
std::vector<Vec3> slopes(const std::vector<double>& size, const Fisher::Model& model) {
    std::vector<double> steps(size.size(), 0.0);
    std::vector<Vec3> out;
    for (std::size_t i = 0; i < size.size(); ++i) {
        steps[i] = size[i];
        const Vec3 up = model(steps);
        steps[i] = -size[i];
        const Vec3 down = model(steps);
        steps[i] = 0.0;
        out.push_back((0.5 / size[i]) * (up - down));
    }
    return out;
}

}  // namespace

Fisher::Fisher(std::vector<double> size)
    : size_(std::move(size)), information_(size_.size(), std::vector<double>(size_.size(), 0.0)) {}

void Fisher::observe(const std::vector<std::size_t>& on, const Vec3& sigma, const Model& model) {
    std::vector<double> size;
    for (const std::size_t i : on) {
        size.push_back(size_[i]);
    }
    const std::vector<Vec3> j = slopes(size, model);
    for (std::size_t a = 0; a < on.size(); ++a) {
        for (std::size_t b = 0; b < on.size(); ++b) {
            double sum = 0.0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                sum += j[a][axis] * j[b][axis] / (sigma[axis] * sigma[axis]);
            }
            information_[on[a]][on[b]] += sum;
        }
    }
}

void Fisher::know(std::size_t parameter, double sigma) { information_[parameter][parameter] += 1.0 / (sigma * sigma); }

std::vector<std::vector<double>> Fisher::bound(std::size_t count) const {
    const std::size_t n = size_.size();
    // In units of the steps, so that pivots of metres and radians compare; the parameters asked for go last, so that
    // what is left when all others are eliminated is their information.
    std::vector<std::vector<double>> m(n, std::vector<double>(n));
    for (std::size_t r = 0; r < n; ++r) {
        for (std::size_t c = 0; c < n; ++c) {
            m[r][c] = information_[r][c] * size_[r] * size_[c];
        }
    }
    for (std::size_t p = n; p-- > count;) {
        if (!(m[p][p] > 0.0)) {
            throw std::runtime_error("the data say nothing of a parameter: no bound");
        }
        for (std::size_t r = 0; r < p; ++r) {
            const double factor = m[r][p] / m[p][p];
            for (std::size_t c = 0; factor != 0.0 && c < p; ++c) {
                m[r][c] -= factor * m[p][c];
            }
        }
    }
    std::vector<std::vector<double>> inverse(count, std::vector<double>(count, 0.0));
    for (std::size_t i = 0; i < count; ++i) {
        inverse[i][i] = 1.0;
    }
    for (std::size_t p = 0; p < count; ++p) {
        const double pivot = m[p][p];
        if (!(pivot > 0.0)) {
            throw std::runtime_error("the data say nothing of what is asked: no bound");
        }
        for (std::size_t c = 0; c < count; ++c) {
            m[p][c] /= pivot;
            inverse[p][c] /= pivot;
        }
        for (std::size_t r = 0; r < count; ++r) {
            const double factor = r == p ? 0.0 : m[r][p];
            for (std::size_t c = 0; factor != 0.0 && c < count; ++c) {
                m[r][c] -= factor * m[p][c];
                inverse[r][c] -= factor * inverse[p][c];
            }
        }
    }
    for (std::size_t r = 0; r < count; ++r) {
        for (std::size_t c = 0; c < count; ++c) {
            inverse[r][c] *= size_[r] * size_[c];
        }
    }
    return inverse;
}

double bound_of_place(const std::vector<std::vector<double>>& bound, const std::vector<double>& size,
                      const Fisher::Model& place) {
    const std::vector<Vec3> j = slopes(size, place);
    double sum = 0.0;
    for (std::size_t a = 0; a < bound.size(); ++a) {
        for (std::size_t b = 0; b < bound.size(); ++b) {
            sum += dot(j[a], j[b]) * bound[a][b];
        }
    }
    return sum;
}

}  // namespace sc::sim
