// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/what_if.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

constexpr std::size_t kPiece = 16384;

}  // namespace

WhatIf::WhatIf(const FaceGauge& gauge, std::span<const BorrowPoint> points, std::span<const BorrowGroup> groups,
               unsigned threads)
    : gauge_(&gauge), points_(points), groups_(groups), threads_(thread_count(threads)) {
    for (const BorrowPoint& point : points) {
        centre_ = centre_ + (1.0 / static_cast<double>(points.size())) * point.place;
    }
    faces_.resize(groups.size());
    tried_.resize(groups.size());
    for (std::uint32_t i = 0; i < points.size(); ++i) {
        faces_[points[i].group].index.push_back(i);
    }
    for (Face& face : faces_) {
        const std::size_t count = face.index.size();
        for (std::size_t k = 0; k < 3; ++k) {
            face.place[k].resize(count);
            face.growth[k].resize(count);
        }
        face.height.resize(count);
        face.now.resize(count);
    }
    base({});
}

const AllowanceReport& WhatIf::base(const Rigid<frame::W, frame::W>& motion) {
    base_ = motion;
    for (std::size_t g = 0; g < faces_.size(); ++g) {
        Face& face = faces_[g];
        parallel_pieces(face.index.size(), kPiece, threads_, [&](std::size_t begin, std::size_t end, unsigned) {
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 place = motion.rotation * points_[face.index[i]].place + motion.translation;
                const Reading reading = gauge_->at(place, groups_[g].face);
                for (std::size_t k = 0; k < 3; ++k) {
                    face.place[k][i] = static_cast<float>((place - centre_)[k]);
                    face.growth[k][i] = static_cast<float>(reading.direction[k]);
                }
                face.height[i] = face.now[i] = static_cast<float>(reading.value);
            }
        });
    }
    report_ = evaluate(*gauge_, points_, groups_, motion, threads_);
    return report_;
}

void WhatIf::try_piece(Face& face, const FaceAllowance& bins, const Mat3& turn, const Vec3& shift, std::size_t begin,
                       std::size_t end, Piece& piece) const {
    // (turn − 1)·place + shift, along the growth, in single precision: differences are small. One loop for arithmetic
    // alone, which a compiler makes wide; one for what is counted.
    std::array<std::array<float, 4>, 3> m{};
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
            m[r][c] = static_cast<float>(turn.row[r][c] - (r == c ? 1.0 : 0.0));
        }
        m[r][3] = static_cast<float>(shift[r]);
    }
    const float* x = face.place[0].data();
    const float* y = face.place[1].data();
    const float* z = face.place[2].data();
    const float* nx = face.growth[0].data();
    const float* ny = face.growth[1].data();
    const float* nz = face.growth[2].data();
    const float* height = face.height.data();
    float* now = face.now.data();
    for (std::size_t i = begin; i < end; ++i) {
        const float dx = m[0][0] * x[i] + m[0][1] * y[i] + m[0][2] * z[i] + m[0][3];
        const float dy = m[1][0] * x[i] + m[1][1] * y[i] + m[1][2] * z[i] + m[1][3];
        const float dz = m[2][0] * x[i] + m[2][1] * y[i] + m[2][2] * z[i] + m[2][3];
        now[i] = height[i] + nx[i] * dx + ny[i] * dy + nz[i] * dz;
    }
    const auto low = static_cast<float>(bins.histogram_low);
    const float per = bins.histogram_width > 0.0 ? static_cast<float>(1.0 / bins.histogram_width) : 0.0F;
    float least = std::numeric_limits<float>::infinity();
    float sum = 0.0F;  // of a piece: 16384 heights
    for (std::size_t i = begin; i < end; ++i) {
        least = std::min(least, now[i]);
        sum += now[i] - low;
        const float bin = std::clamp((now[i] - low) * per, 0.0F, static_cast<float>(kHistogram) - 1.0F);
        ++piece.histogram[static_cast<std::size_t>(bin)];
    }
    piece.least = static_cast<double>(least);
    piece.sum = static_cast<double>(sum) + static_cast<double>(low) * static_cast<double>(end - begin);
}

std::span<const TriedFace> WhatIf::frame(const Rigid<frame::W, frame::W>& motion) {
    // From the base: motion · base⁻¹, about the centre.
    const Rigid<frame::W, frame::W> step = motion * base_.inverse();
    const Vec3 shift = step.rotation * centre_ + step.translation - centre_;
    for (std::size_t g = 0; g < faces_.size(); ++g) {
        Face& face = faces_[g];
        TriedFace& tried = tried_[g];
        tried = {.count = face.index.size(), .least = 0.0, .mean = 0.0, .histogram = {}};
        if (face.index.empty()) {
            continue;
        }
        std::vector<Piece> pieces((face.index.size() + kPiece - 1) / kPiece);
        parallel_pieces(face.index.size(), kPiece, threads_, [&](std::size_t begin, std::size_t end, unsigned) {
            try_piece(face, report_.faces[g], step.rotation, shift, begin, end, pieces[begin / kPiece]);
        });
        tried.least = std::numeric_limits<double>::infinity();
        double sum = 0.0;
        for (const Piece& piece : pieces) {
            tried.least = std::min(tried.least, piece.least);
            sum += piece.sum;
            for (std::size_t k = 0; k < kHistogram; ++k) {
                tried.histogram[k] += piece.histogram[k];
            }
        }
        tried.mean = sum / static_cast<double>(face.index.size());
    }
    return tried_;
}

std::vector<float> WhatIf::margins() const {
    std::vector<float> out(points_.size());
    for (std::size_t g = 0; g < faces_.size(); ++g) {
        for (std::size_t i = 0; i < faces_[g].index.size(); ++i) {
            out[faces_[g].index[i]] = faces_[g].now[i] - static_cast<float>(groups_[g].least);
        }
    }
    return out;
}

}  // namespace sc::host
