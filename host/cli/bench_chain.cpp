// SPDX-License-Identifier: Apache-2.0
#include "host/cli/bench_chain.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "host/bridge/child_process.hpp"
#include "host/bridge/errors.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/paper_methods.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/file.hpp"
#include "host/registration/stitch.hpp"

namespace sc::host::cli {
namespace {

namespace fs = std::filesystem;

constexpr double kRegion95 = 7.8147;  ///< chi-squared, 3 degrees of freedom
constexpr std::size_t kGroups = 10;
constexpr double kStudent95 = 2.262;  ///< 9 degrees of freedom

/// A mark of the workpiece: where the axes stand when the beam meets it, and what a person would have read.
struct Mark {
    int id = 0;
    double face_deg = 0.0;
    Vec3 met;
    Vec3 pointed;
};

std::vector<Mark> read_marks(const fs::path& file) {
    const CsvTable csv = CsvTable::read(file);
    std::vector<Mark> out;
    for (std::size_t row = 0; row < csv.size(); ++row) {
        const auto place = [&](const std::array<const char*, 3>& names) {
            return Vec3{csv.number(row, csv.column(names[0])) * 1e-3, csv.number(row, csv.column(names[1])) * 1e-3,
                        csv.number(row, csv.column(names[2])) * 1e-3};
        };
        out.push_back({csv.integer(row, csv.column("id")), csv.number(row, csv.column("face_deg")),
                       place({"x_mm", "y_mm", "z_mm"}), place({"pointed_x_mm", "pointed_y_mm", "pointed_z_mm"})});
    }
    return out;
}

double percentile(std::vector<double> values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

/// Differences of one kind over all sets, µm.
struct Spread {
    std::vector<std::vector<double>> sets;  ///< axis values of each

    void add(const Vec3& difference) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            sets.back().push_back(1e6 * std::abs(difference[axis]));
        }
    }
    [[nodiscard]] double p95(std::size_t first = 0, std::size_t stride = 1) const {
        std::vector<double> all;
        for (std::size_t i = first; i < sets.size(); i += stride) {
            all.insert(all.end(), sets[i].begin(), sets[i].end());
        }
        return percentile(all, 0.95);
    }
    /// Half of the 95 % confidence interval of p95, from groups of sets; 0 for fewer sets than groups.
    [[nodiscard]] double half_interval() const {
        if (sets.size() < kGroups) {
            return 0.0;
        }
        std::vector<double> groups;
        double mean = 0.0;
        for (std::size_t g = 0; g < kGroups; ++g) {
            groups.push_back(p95(g, kGroups));
            mean += groups.back() / static_cast<double>(kGroups);
        }
        double square = 0.0;
        for (const double v : groups) {
            square += (v - mean) * (v - mean);
        }
        return kStudent95 * std::sqrt(square / static_cast<double>(kGroups * (kGroups - 1)));
    }
    [[nodiscard]] double max_median() const {
        std::vector<double> most;
        for (const auto& set : sets) {
            most.push_back(*std::ranges::max_element(set));
        }
        return percentile(most, 0.5);
    }
};

struct Score {
    Spread scribed;   ///< beam against the mark
    Spread verified;  ///< against what a person reads who points at it
    Spread stepwise;  ///< scribed, by closed forms, each view to all views before it
    Spread chained;   ///< scribed, as the paper does it
    double inside = 0.0;
    double places = 0.0;
    double seconds = 0.0;
    double robot_ratio = 0.0;
    std::string rows = "set,scribed_max_um,verified_max_um,chained_max_um\n";
};

bool is_inside(const ChainPlace& place, const Vec3& off) {
    Eigen::Matrix3d covariance;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            covariance(r, c) = place.covariance.at[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
        }
    }
    const Eigen::Vector3d error(off.x, off.y, off.z);
    return error.dot(covariance.llt().solve(error)) <= kRegion95;
}

ChainInput read_cell(const fs::path& set) {
    ChainInput input =
        chain_input(read_scan_set(set / "scan_set.toml"),
                    {.targets = {read_target(set / "references.toml"), read_target(set / "mobile.toml")}, .still = {}});
    input.pointing_file = set / "pointing.csv";
    input.pointing = read_marker_views(input.pointing_file).views;
    return input;
}

Vec3 place_of(const std::vector<ChainPlace>& places, int id) {
    const auto at = std::ranges::find(places, id, &ChainPlace::id);
    if (at == places.end()) {
        throw CellError(fmt::format("mark {} is not among the places", id));
    }
    return at->place;
}

Score score_cells(const fs::path& folder, RobotUse robot) {
    const CsvTable truth = CsvTable::read(folder / "truth.csv");
    Score score;
    for (std::size_t row = 0; row < truth.size(); ++row) {
        if (stop_requested()) {
            throw Interrupted();
        }
        const std::string& name = truth.text(row, truth.column("set"));
        const fs::path set = folder / name;
        const std::vector<Mark> marks = read_marks(set / "marks.csv");
        const ChainInput input = read_cell(set);
        ChainOptions options;
        options.robot = robot;
        for (const Mark& m : marks) {
            options.predict.push_back({m.id, m.face_deg});
        }
        const auto begin = std::chrono::steady_clock::now();
        const ChainResult bundle = fit_chain(input, options);
        score.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        score.robot_ratio += bundle.robot_ratio;
        const ChainResult steps = chain_step_by_step(input, options);
        const std::vector<ChainPlace> chained = paper_places(input, options.predict);
        for (Spread* s : {&score.scribed, &score.verified, &score.stepwise, &score.chained}) {
            s->sets.emplace_back();
        }
        for (const Mark& m : marks) {
            const auto place = std::ranges::find(bundle.places, m.id, &ChainPlace::id);
            if (place == bundle.places.end()) {
                throw CellError(fmt::format("{}: mark {} is not among the places", set.string(), m.id));
            }
            score.scribed.add(place->place - m.met);
            score.verified.add(place->place - m.pointed);
            score.stepwise.add(place_of(steps.places, m.id) - m.met);
            score.chained.add(place_of(chained, m.id) - m.met);
            score.inside += is_inside(*place, place->place - m.met) ? 1.0 : 0.0;
            score.places += 1.0;
        }
        const auto most = [](const Spread& s) { return *std::ranges::max_element(s.sets.back()); };
        score.rows += fmt::format("{},{:.3f},{:.3f},{:.3f}\n", name, most(score.scribed), most(score.verified),
                                  most(score.chained));
    }
    return score;
}

class Chains {
public:
    Chains(const BenchOptions& options, fs::path folder, std::string& rows)
        : options_(options), folder_(std::move(folder)), rows_(rows) {}

    std::vector<Figure> run() {
        const Score ring = score("ring_10", {}, "10");
        add("ring_95_um", ring.scribed.p95());
        add("ring_95_half_interval_um", ring.scribed.half_interval());
        add("ring_max_median_um", ring.scribed.max_median());
        add("ring_verified_95_um", ring.verified.p95());
        add("ring_verified_max_median_um", ring.verified.max_median());
        const double coverage = 100.0 * ring.inside / ring.places;
        figures_.push_back({"ring_coverage_pct", coverage, "%"});
        figures_.push_back({"ring_coverage_over_pct", coverage, "%"});
        add("ring_chained_95_um", ring.chained.p95());
        add("ring_chained_max_median_um", ring.chained.max_median());
        add("ring_stepwise_95_um", ring.stepwise.p95());
        figures_.push_back({"ring_ms", 1e3 * ring.seconds / static_cast<double>(ring.scribed.sets.size()), "ms"});
        for (const char* um : {"0", "25", "55"}) {
            const Score s = score(std::string("ring_") + um, {}, um);
            add(fmt::format("ring_95_at_{}_um", um), s.scribed.p95());
            add(fmt::format("ring_max_median_at_{}_um", um), s.scribed.max_median());
            add(fmt::format("ring_verified_95_at_{}_um", um), s.verified.p95());
            add(fmt::format("ring_verified_max_median_at_{}_um", um), s.verified.max_median());
        }
        const Score dh = score("ring_dh", {"--robot", "dh"}, "10");
        figures_.push_back(
            {"ring_dh_robot_change_pct", 100.0 * std::abs(dh.scribed.p95() / ring.scribed.p95() - 1.0), "%"});
        add("ring_dh_95_um", dh.scribed.p95());
        figures_.push_back({"ring_dh_noise_found", dh.robot_ratio / static_cast<double>(dh.scribed.sets.size()), ""});
        corner();
        return figures_;
    }

private:
    void corner() {
        const std::vector<std::string> paper{"--references", "corner", "--mobile", "12", "--angles", "12"};
        const fs::path sets = make("corner", paper, "10");
        const Score alone = score_cells(sets, RobotUse::left_out);
        note("corner", sets, alone);
        add("corner_95_um", alone.scribed.p95());
        add("corner_max_median_um", alone.scribed.max_median());
        add("corner_chained_95_um", alone.chained.p95());
        add("corner_verified_max_median_um", alone.verified.max_median());
        const double coverage = 100.0 * alone.inside / alone.places;
        figures_.push_back({"corner_coverage_pct", coverage, "%"});
        add("corner_with_robot_95_um", score_cells(sets, RobotUse::weighed).scribed.p95());
        clear(sets);
    }

    fs::path make(const std::string& name, std::vector<std::string> arguments, const char* pointing_um) {
        std::fprintf(stderr, "%s\n", name.c_str());
        fs::path out = folder_ / name;
        arguments.insert(arguments.begin(), "chain");
        arguments.insert(arguments.end(),
                         {"--out", out.string(), "--sets", std::to_string(options_.sets), "--seed",
                          std::to_string(options_.seed * 100 + 50 + ++kinds_), "--pointing-um", pointing_um});
        if (run_program(required_program("scribecell-rig"), arguments).exit_code != 0) {
            throw CellError("scribecell-rig made no data");
        }
        return out;
    }
    Score score(const std::string& name, const std::vector<std::string>& arguments, const char* pointing_um) {
        const fs::path sets = make(name, arguments, pointing_um);
        Score out = score_cells(sets, RobotUse::weighed);
        note(name, sets, out);
        clear(sets);
        return out;
    }
    void note(const std::string& name, const fs::path& sets, const Score& score) {
        write_text_file(sets / "errors.csv", score.rows);
        rows_ += fmt::format("{}_95_um,{:.3f}\n{}_95_half_interval_um,{:.3f}\n", name, score.scribed.p95(), name,
                             score.scribed.half_interval());
    }
    /// A thousand cells are a hundred megabytes: they stay only where they were asked for.
    void clear(const fs::path& sets) const {
        if (!options_.raw) {
            fs::remove_all(sets);
        }
    }
    void add(std::string name, double um) { figures_.push_back({std::move(name), um, "um"}); }

    BenchOptions options_;
    fs::path folder_;
    std::string& rows_;
    std::uint64_t kinds_ = 0;
    std::vector<Figure> figures_;
};

}  // namespace

std::vector<Figure> bench_chain(const BenchOptions& options, const fs::path& folder, std::string& rows) {
    return Chains(options, folder, rows).run();
}

}  // namespace sc::host::cli
