// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/scribe_budget.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <Eigen/Dense>

#include "host/calibration/galvo_model.hpp"
#include "host/calibration/motion.hpp"
#include "host/calibration/transforms.hpp"
#include "host/formats/calibration_records.hpp"
#include "host/formats/error.hpp"

namespace sc::host {

namespace {

constexpr double kNormal95 = 1.959964;
constexpr std::array<std::array<std::size_t, 2>, 3> kAxisOfShear{{{0, 1}, {0, 2}, {1, 2}}};

/// How a record's parameters move a place.
struct Sensitivity {
    std::string id;
    Eigen::Matrix3Xd jacobian;
};

Eigen::MatrixXd matrix_of(const std::vector<std::vector<double>>& rows) {
    Eigen::MatrixXd out(rows.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t j = 0; j < rows.size(); ++j) {
            out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
        }
    }
    return out;
}

PlaceCovariance plain(const Eigen::Matrix3d& m) {
    PlaceCovariance out{};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            out[i][j] = m(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
    }
    return out;
}

Eigen::Matrix3Xd by_differences(std::size_t parameters, const std::vector<double>& steps,
                                const std::function<Eigen::Vector3d(std::size_t, double)>& place) {
    Eigen::Matrix3Xd out(3, parameters);
    for (std::size_t i = 0; i < parameters; ++i) {
        out.col(static_cast<Eigen::Index>(i)) = (place(i, steps[i]) - place(i, -steps[i])) / (2.0 * steps[i]);
    }
    return out;
}

Eigen::Matrix3Xd by_turntable(const AxisLine& axis, double c_deg, const Eigen::Vector3d& at_zero) {
    const auto moved = [&](std::size_t i, double step) {
        AxisLine line = axis;
        Vec3& p = line.point.v;
        Vec3& d = line.direction.v;
        std::array<double*, 4>{&p.x, &p.y, &d.x, &d.y}[i][0] += step;
        d.z = std::sqrt(std::max(0.0, 1.0 - d.x * d.x - d.y * d.y));
        return to_eigen((h_from_t(line, c_deg) * Point<frame::T>{to_vec(at_zero)}).v);
    };
    return by_differences(4, {1e-5, 1e-5, 1e-5, 1e-5}, moved);
}

/// The focus stands at A q for readings q that were to bring it to `place`: δp = δA q, order xy,xz,yz,sx,sy,sz.
Eigen::Matrix3Xd by_axes(const Eigen::Vector3d& place) {
    Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, 6);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto row = static_cast<Eigen::Index>(kAxisOfShear[i][0]);
        const auto along = static_cast<Eigen::Index>(kAxisOfShear[i][1]);
        out(row, static_cast<Eigen::Index>(i)) = place(along);
        out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i) + 3) = place(static_cast<Eigen::Index>(i));
    }
    return out;
}

Eigen::Matrix3Xd by_galvo(const std::array<double, 2>& field) {
    Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, 6);
    out(0, 0) = out(2, 1) = 1.0;
    out(0, 2) = out(2, 4) = field[0];
    out(0, 3) = out(2, 5) = field[1];
    return out;
}

Eigen::Matrix3Xd by_galvo_field(const GalvoFieldRecord& record, const std::array<double, 2>& field) {
    const GalvoModel model = GalvoModel::from(record);
    const FieldPlace command = model.command_for({field[0], field[1]});
    const auto moved = [&](std::size_t i, double step) {
        GalvoModel other = model;
        other.value.at(i) += step;
        const FieldPlace p = other.land(command, 0.0);
        return Eigen::Vector3d(p[0], 0.0, p[1]);
    };
    return by_differences(GalvoModel::kParameters, std::vector<double>(GalvoModel::kParameters, 1e-6), moved);
}

/// The transforms of a chain, for a place that was `in_h` before the table turned.
std::vector<Sensitivity> by_chain(const std::vector<ChainLink>& chain, const Eigen::Vector3d& in_h,
                                  const Eigen::Matrix3d& turn) {
    std::vector<Sensitivity> out;
    Eigen::Matrix3d before = turn;
    Eigen::Vector3d place = in_h;  // in the frame on the left of the link
    for (const ChainLink& link : chain) {
        const Motion x{to_eigen(link.record->rotation), to_eigen(link.record->translation)};
        const Motion used = link.inverted ? x.inverse() : x;
        const Eigen::Vector3d right = used.inverse() * place;
        Eigen::Matrix<double, 3, 6> jacobian;
        // Exp(ξ) acts in the frame on the left of the record's name.
        const Eigen::Vector3d& moved = link.inverted ? right : place;
        jacobian << -skew(moved), Eigen::Matrix3d::Identity();
        out.push_back({link.record->id, link.inverted ? Eigen::Matrix3Xd(-before * used.r * jacobian)
                                                      : Eigen::Matrix3Xd(before * jacobian)});
        before = before * used.r;
        place = right;
    }
    return out;
}

class Budgeter {
public:
    Budgeter(const CalibrationSet& set, const BudgetNoise& noise, ScribeBudget& out)
        : set_(set),
          noise_(noise),
          axis_(turntable_axis(set)),
          chain_(chain_between(set, "h", "c")),
          blocks_(covariance_blocks(set)),
          joint_(matrix_of(joint_covariance(set, blocks_))) {
        if (chain_.empty()) {
            throw InputError({.file = set.file.string(),
                              .problem = "the calibration has no way from c to h",
                              .value = "h_from_c",
                              .action = "use a complete calibration set"});
        }
        Eigen::Index at = 0;
        for (const CovarianceBlock& block : blocks_) {
            start_[block.id] = at;
            at += static_cast<Eigen::Index>(block.at.size());
        }
        if (!set.axes) {
            out.notes.emplace_back("the set has no [axes]: their errors are taken to be none");
        }
        if (!set.galvo && !set.galvo_field) {
            out.notes.emplace_back("the set has no [galvo] or [galvo_field]: their errors are taken to be none");
        }
    }

    [[nodiscard]] PlaceBudget at(const BudgetPlace& place) const {
        const Eigen::Vector3d there = to_eigen(place.place.v);
        const auto turned_to = h_from_t(axis_, c_of_face(place.face_deg));
        const Eigen::Matrix3d turn = to_eigen(turned_to.rotation);
        const Eigen::Vector3d at_zero = to_eigen((turned_to.inverse() * place.place).v);
        std::vector<Sensitivity> records;
        if (place.measured) {
            records = by_chain(chain_, at_zero, turn);
        } else {
            for (const ChainLink& link : chain_) {
                records.push_back({link.record->id, Eigen::Matrix3Xd::Zero(3, 6)});
            }
        }
        records.push_back({"turntable", place.measured ? by_turntable(axis_, c_of_face(place.face_deg), at_zero)
                                                       : Eigen::Matrix3Xd(Eigen::Matrix3Xd::Zero(3, 4))});
        if (set_.axes) {
            records.push_back({"axes", by_axes(there)});
        }
        if (set_.galvo_field) {
            records.push_back({"galvo_field", by_galvo_field(*set_.galvo_field, noise_.field)});
        } else if (set_.galvo) {
            records.push_back({"galvo", by_galvo(noise_.field)});
        }
        return finish(place, records);
    }

private:
    [[nodiscard]] PlaceBudget finish(const BudgetPlace& place, const std::vector<Sensitivity>& records) const {
        PlaceBudget out;
        out.at = place;
        Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
        const auto add = [&](const std::string& name, const Eigen::Matrix3d& covariance) {
            out.sources.push_back({name, plain(covariance)});
            total += covariance;
        };
        const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
        const double measured = place.measured ? 1.0 : 0.0;
        add("sensor", measured * noise_.sensor * noise_.sensor * one);
        add("registration", measured * noise_.registration * noise_.registration * one);
        Eigen::Matrix3d shared = Eigen::Matrix3d::Zero();
        for (std::size_t a = 0; a < records.size(); ++a) {
            for (std::size_t b = 0; b <= a; ++b) {
                const Eigen::Matrix3d part = records[a].jacobian *
                                             joint_.block(start_.at(records[a].id), start_.at(records[b].id),
                                                          records[a].jacobian.cols(), records[b].jacobian.cols()) *
                                             records[b].jacobian.transpose();
                if (a == b) {
                    add(records[a].id, part);
                } else {
                    shared += part + part.transpose();
                }
            }
        }
        const Eigen::Vector3d arm = to_eigen(place.place.v - axis_.point.v);
        const Eigen::Vector3d way = to_eigen(axis_.direction.v).cross(arm);
        add("table angle", noise_.turn * noise_.turn * way * way.transpose());
        add("axes positioning", noise_.axes * noise_.axes * one);
        if (!set_.cross.empty()) {
            add("shared", shared);
        }
        out.total = plain(total);
        const Eigen::Vector3d sigma = total.diagonal().cwiseMax(0.0).cwiseSqrt();
        out.axis_95 = to_vec(kNormal95 * sigma);
        out.distance_95 = distance_95(out.total);
        out.checked_95 = kNormal95 * std::hypot(sigma.maxCoeff(), noise_.pointing);
        return out;
    }

    const CalibrationSet& set_;
    BudgetNoise noise_;
    AxisLine axis_;
    std::vector<ChainLink> chain_;
    std::vector<CovarianceBlock> blocks_;
    Eigen::MatrixXd joint_;
    std::map<std::string, Eigen::Index> start_;
};

}  // namespace

double distance_95(const PlaceCovariance& covariance) noexcept {
    double trace = 0.0;
    double squares = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        trace += covariance[i][i];
        for (std::size_t j = 0; j < 3; ++j) {
            squares += covariance[i][j] * covariance[i][j];
        }
    }
    if (!(trace > 0.0)) {
        return 0.0;
    }
    const double freedom = trace * trace / squares;
    const double part = 2.0 / (9.0 * freedom);
    const double root = 1.0 - part + 1.644854 * std::sqrt(part);
    return std::sqrt(squares / trace * freedom * root * root * root);
}

std::optional<std::array<std::string, 2>> frames_of(const std::string& id) {
    constexpr std::string_view kFrom = "_from_";
    const std::size_t at = id.find(kFrom);
    if (at == std::string::npos || at == 0 || at + kFrom.size() >= id.size()) {
        return std::nullopt;
    }
    return std::array{id.substr(0, at), id.substr(at + kFrom.size())};
}

std::vector<ChainLink> chain_between(const CalibrationSet& set, const std::string& to, const std::string& from) {
    // Breadth first from `to`; `way` holds how each frame was reached.
    std::map<std::string, std::vector<ChainLink>> way{{to, {}}};
    std::vector<std::string> front{to};
    while (!front.empty() && !way.contains(from)) {
        std::vector<std::string> next;
        for (const std::string& frame : front) {
            for (const TransformRecord& record : set.transforms) {
                const auto frames = frames_of(record.id);
                if (!frames || ((*frames)[0] != frame && (*frames)[1] != frame)) {
                    continue;
                }
                const bool inverted = (*frames)[1] == frame;
                const std::string& other = (*frames)[inverted ? 0 : 1];
                if (!way.contains(other)) {
                    std::vector<ChainLink> links = way.at(frame);
                    links.push_back({&record, inverted});
                    way.emplace(other, std::move(links));
                    next.push_back(other);
                }
            }
        }
        front = std::move(next);
    }
    const auto found = way.find(from);
    return found == way.end() ? std::vector<ChainLink>{} : found->second;
}

ScribeBudget scribe_budget(const CalibrationSet& set, const std::vector<BudgetPlace>& places,
                           const BudgetNoise& noise) {
    ScribeBudget out;
    const Budgeter budgeter(set, noise, out);
    for (const BudgetPlace& place : places) {
        out.places.push_back(budgeter.at(place));
    }
    return out;
}

}  // namespace sc::host
