// SPDX-License-Identifier: Apache-2.0
#include "host/inspection/inspection.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"
#include "host/inspection/parallel.hpp"

namespace sc::host {

namespace {

constexpr double kAnotherPart = 0.015;  ///< of the diagonal: spread of the surfaces that should fit
constexpr double kLeastCoverage = 0.3;
constexpr double kReach = 0.04;  ///< of the diagonal: metal to be cut off hides the CAD surface by less

/// Runs the steps, tells them and times them.
class Steps {
public:
    Steps(const InspectionRequest& request, Inspection& out) : request_(&request), out_(&out) {}

    template <class Work>
    void run(const char* name, const Work& work) {
        if (request_->progress) {
            request_->progress(name);
        }
        const auto start = std::chrono::steady_clock::now();
        work();
        out_->seconds.emplace_back(name,
                                   std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }

private:
    const InspectionRequest* request_;
    Inspection* out_;
};

/// Extent of all but one in two hundred at each end: an outlier is no size.
double robust_diagonal(std::span<const Vec3> points) {
    double sum = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> v;
        const std::size_t stride = std::max<std::size_t>(1, points.size() / 20000);
        for (std::size_t i = 0; i < points.size(); i += stride) {
            v.push_back(points[i][axis]);
        }
        std::ranges::sort(v);
        const double size = v[v.size() - 1 - v.size() / 200] - v[v.size() / 200];
        sum += size * size;
    }
    return std::sqrt(sum);
}

/// Triangles that may decide the fit: all, those that stay as cast, or those of named features.
std::vector<bool> deciding(const Inspection& out, const Part* part, const InspectionRequest& request) {
    std::vector<bool> use;
    if (part == nullptr) {
        return use;
    }
    std::vector<bool> wanted(out.plan.groups.size(), false);
    for (const std::string& id : request.features) {
        bool found = false;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            const std::string padded = "+" + out.plan.groups[i].id + "+";
            if (padded.find("+" + id + "+") != std::string::npos) {
                wanted[i] = found = true;
            }
        }
        if (!found) {
            throw InputError({.file = {},
                              .problem = "the part has no feature to align by",
                              .value = id,
                              .action = "name ids of [[machined]] entries"});
        }
    }
    for (const std::uint32_t face : out.map.face_of) {
        const std::uint32_t group = out.plan.group_of_face[face];
        use.push_back(request.features.empty() ? group == kNoGroup : group != kNoGroup && wanted[group]);
    }
    return use;
}

void check_closed(const DistanceField& field, const InspectionRequest& request, Inspection& out) {
    out.closed = field.topology().closed();
    out.shells = field.topology().shells;
    if (!out.closed && !request.open_allowed) {
        throw InputError({.file = {},
                          .problem = "the CAD model is not closed, so inside and outside are not known",
                          .value = open_text(field.topology()),
                          .action = "export a closed solid, or say --open to trust the sign near faces only"});
    }
    if (!out.closed) {
        out.notes.push_back("the CAD model is not closed; signs hold near its faces only: " +
                            open_text(field.topology()));
    }
    if (field.turned()) {
        out.notes.emplace_back("the CAD model's triangles faced inwards; they were turned over");
    }
}

void align(const DistanceField& field, std::span<const Vec3> scan, const Part* part, const InspectionRequest& request,
           Inspection& out, Steps& steps) {
    Placement start;
    if (request.start) {
        start = *request.start;
    } else {
        steps.run("global start", [&] {
            const GlobalStart found = global_start(field, scan, request.threads);
            start = found.w_from_c;
            if (found.second < 1.1 * found.score) {
                out.notes.emplace_back(
                    "another placement fits nearly as well: the part looks alike from two sides; "
                    "check the picture, or give the placement");
            }
        });
    }
    steps.run("fit", [&] {
        FitOptions options{.threads = request.threads, .use = {}, .reach = 0.05 * field.diagonal()};
        out.fit = fit_to_mesh(field, scan, start, options);
        options.use = deciding(out, part, request);
        if (!options.use.empty()) {
            out.fit = fit_to_mesh(field, scan, out.fit.w_from_c, options);
        }
        out.w_from_c = out.fit.w_from_c;
    });
    if (out.fit.sigma > kAnotherPart * field.diagonal()) {
        throw InspectionError("the scan does not fit the CAD model: at the best placement half of it lies more than " +
                              fixed(1e3 * out.fit.sigma / 1.4826, 2) +
                              " mm off; is it a scan of another part, or of its fixture?");
    }
    if (out.fit.stiffness < 1e-7) {
        out.notes.emplace_back("the surfaces leave a motion of the part open (a round part turns in itself)");
    }
    steps.run("coverage", [&] { out.coverage = coverage(field, scan, out.w_from_c, kReach * field.diagonal()); });
    if (out.coverage < kLeastCoverage) {
        throw InspectionError("the scan shows " + fixed(100.0 * out.coverage, 0) +
                              " % of the CAD surface: too little to place the part; scan it from more sides");
    }
    const bool references = part != nullptr && part->reference_points.size() >= 6;
    out.aligned_by =
        request.align == AlignBy::automatic ? (references ? AlignBy::references : AlignBy::best_fit) : request.align;
    if (out.aligned_by == AlignBy::references) {
        steps.run("references", [&] {
            const std::vector<ReferencePoint> none;
            const ReferenceAlignment found =
                align_by_references(part == nullptr ? none : part->reference_points, scan, out.w_from_c);
            out.w_from_c = found.w_from_c;
            out.references = found.references;
        });
    }
}

void cut_lines(const DistanceField& field, std::span<const Vec3> scan, const Part* part,
               const InspectionRequest& request, Inspection& out) {
    if (part == nullptr || part->datums.empty()) {
        throw InputError({.file = {},
                          .problem = "the part has no datum plane to cut a line with",
                          .value = part == nullptr ? "" : part->id,
                          .action = "add [[datum]] entries to the part, and give it with --part"});
    }
    const std::vector<Vec3> places = placed(out.final_w_from_c(), scan);
    for (const DatumPlane& datum : part->datums) {
        out.lines.push_back(datum_line(field, places, datum, {.threads = request.threads}));
        const auto& notes = out.lines.back().notes;
        out.notes.insert(out.notes.end(), notes.begin(), notes.end());
    }
}

}  // namespace

std::string_view name_of(AlignBy by) noexcept {
    switch (by) {
        case AlignBy::automatic: return "auto";
        case AlignBy::best_fit: return "fit";
        case AlignBy::references: return "rps";
        case AlignBy::features: return "features";
    }
    return "?";
}

void check_size(const DistanceField& field, std::span<const Vec3> scan) {
    const double cad = field.diagonal();
    const double seen = robust_diagonal(scan);
    const double ratio = seen / cad;
    const std::string sizes =
        "the scan is " + about(1e3 * seen) + " mm across, the CAD model " + about(1e3 * cad) + " mm";
    struct Scale {
        double factor;
        const char* text;
    };
    for (const Scale& scale :
         {Scale{1000.0, "1000 times too large: its numbers are micrometres, or the CAD model's are metres"},
          Scale{25.4, "25.4 times too large: the CAD model's numbers are inches"},
          Scale{1.0 / 25.4, "25.4 times too small: its numbers are inches"},
          Scale{1e-3, "1000 times too small: its numbers are metres"}}) {
        if (std::abs(std::log(ratio / scale.factor)) < std::log(2.0)) {
            throw InspectionError(std::string("the scan is about ") + scale.text + " (" + sizes +
                                  "); say so with --scan-unit or --cad-unit");
        }
    }
    if (ratio < 0.2 || ratio > 3.0) {
        throw InspectionError(sizes +
                              ": this is a scan of another part, of too little of it, or one with its surroundings");
    }
}

Inspection inspect(const DistanceField& field, std::span<const Vec3> scan, const Part* part,
                   const InspectionRequest& request) {
    Inspection out;
    Steps steps(request, out);
    out.points = scan.size();
    check_closed(field, request, out);
    check_size(field, scan);
    steps.run("faces", [&] {
        out.map = segmented(field.mesh(), field.topology());
        out.plan = part != nullptr ? plan_from(*part, field, out.map) : plan_for_all(out.map, request.least);
        out.notes.insert(out.notes.end(), out.plan.notes.begin(), out.plan.notes.end());
    });
    align(field, scan, part, request, out, steps);
    const std::vector<Vec3> places = placed(out.w_from_c, scan);
    std::vector<Distance> distances(places.size());
    const FaceGauge gauge(field, out.map);
    steps.run("distances", [&] { field.measure(places, distances, {.threads = request.threads}); });
    steps.run("allowance", [&] {
        out.over = points_over(field, out.map, out.plan, places, distances, request.threads);
        out.as_cast = as_cast(out.map, out.plan, distances);
        out.before = evaluate(gauge, out.over.points, out.plan.groups, {}, request.threads);
    });
    for (const FaceAllowance& face : out.before.faces) {
        if (face.count == 0) {
            out.notes.push_back("no scanned point lies over " + face.id + ": nothing is known of it");
        }
    }
    if (request.borrow) {
        steps.run("borrowing", [&] {
            BorrowOptions options = request.borrowing;
            options.threads = request.threads;
            out.borrowing = borrow(field, gauge, out.over.points, out.plan.groups, options);
            out.after = evaluate(gauge, out.over.points, out.plan.groups, out.borrowing->motion, request.threads);
        });
    }
    if (request.lines) {
        steps.run("lines", [&] { cut_lines(field, scan, part, request, out); });
    }
    if (request.what_if) {
        out.what_if = evaluate(gauge, out.over.points, out.plan.groups, *request.what_if, request.threads);
    }
    return out;
}

std::vector<Conflict> conflicts(const Inspection& inspection) {
    std::vector<Conflict> out;
    if (!inspection.borrowing) {
        return out;
    }
    for (const ActivePoint& active : inspection.borrowing->active) {
        const BorrowGroup& group = inspection.plan.groups[active.group];
        auto found = std::ranges::find(out, group.id, &Conflict::id);
        if (found == out.end()) {
            out.push_back({group.id, 0.0, group.least, group.least + inspection.borrowing->margin});
            found = out.end() - 1;
        }
        found->share += active.multiplier;
    }
    std::ranges::sort(out, [](const Conflict& a, const Conflict& b) { return a.share > b.share; });
    return out;
}

}  // namespace sc::host
