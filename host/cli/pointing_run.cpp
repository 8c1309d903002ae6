// SPDX-License-Identifier: Apache-2.0
#include "host/cli/pointing_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <thread>

#include <fmt/format.h>

#include "host/bridge/errors.hpp"
#include "host/bridge/open_transport.hpp"
#include "host/bridge/program.hpp"
#include "host/bridge/stop.hpp"
#include "host/cli/calibrate_run.hpp"
#include "host/cli/jog_session.hpp"
#include "host/cli/override_keys.hpp"
#include "host/cli/record_keys.hpp"
#include "host/formats/csv.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kSurvey = "scribecell-survey";
constexpr const char* kLog = "pointing.csv";
constexpr const char* kLogHeader = "id,x_mm,y_mm,z_mm,distance_mm,distance_sigma_mm,looks\n";
constexpr int kSensorSamples = 16;
constexpr Nanoseconds kWait = std::chrono::milliseconds(5);
constexpr double kClose = 60e-6;  ///< metres: nearer than that a person looks once more and takes it

[[noreturn]] void refuse(const std::filesystem::path& file, std::string problem, std::string value,
                         std::string action) {
    throw InputError(
        {.file = file.string(), .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

/// What brings the spot onto a marker.
class Operator {
public:
    enum class Word : std::uint8_t { taken, skipped, stopped };
    virtual ~Operator() = default;
    /// `focus`: along the beam too, not only across.
    virtual Word align(JogMoves& moves, int marker, bool focus) = 0;
};

/// A program that sees as a person does, and moves as one would.
class SimulatedPerson : public Operator {
public:
    SimulatedPerson(const PointingOptions& options, std::filesystem::path world)
        : options_(options), world_(std::move(world)) {}
    Word align(JogMoves& moves, int marker, bool focus) override {
        for (int attempt = 0; attempt < 6; ++attempt) {
            const Vec3 off = look(moves, marker);
            moves.by(0, -off.x);
            moves.by(2, -off.z);
            if (focus) {
                moves.by(1, -off.y);
            }
            if (attempt > 0 && std::max(std::abs(off.x), std::abs(off.z)) < kClose &&
                (!focus || std::abs(off.y) < 4e-6 * options_.focusing_um)) {
                return Word::taken;
            }
        }
        return Word::taken;
    }

private:
    Vec3 look(JogMoves& moves, int marker) {
        const Vec3 at = 1e3 * moves.place();
        const ProgramOutput seen = run_program(
            required_program(kSurvey),
            {"spot", "--world", world_.string(), "--seed", std::to_string(options_.seed), "--marker",
             std::to_string(marker), fmt::format("--at-mm={:.7f},{:.7f},{:.7f}", at.x, at.y, at.z), "--look",
             std::to_string(1000 * marker + looks_++), "--pointing-um", fmt::format("{}", options_.pointing_um),
             "--focusing-um", fmt::format("{}", options_.focusing_um)});
        Vec3 off;
        if (seen.exit_code != 0 || std::sscanf(seen.text.c_str(), "%lf %lf %lf", &off.x, &off.y, &off.z) != 3) {
            throw CellError(fmt::format("{} does not see marker {}", kSurvey, marker));
        }
        return 1e-6 * off;
    }

    const PointingOptions& options_;
    std::filesystem::path world_;
    int looks_ = 0;
};

/// Keys, from a terminal or a file: a d x, w s z, e q y; 1 to 4 the step; t takes, n skips, x ends.
class KeyPerson : public Operator {
public:
    explicit KeyPerson(const std::optional<std::filesystem::path>& file) {
        if (file) {
            script_ = read_text_file(*file);
        } else {
            terminal_ = std::make_unique<TerminalKeys>();
            if (!terminal_->open()) {
                refuse({}, "nobody is there to point: stdin is no terminal", {},
                       "run it in a terminal, or give --keys");
            }
        }
    }
    Word align(JogMoves& moves, int marker, bool focus) override {
        std::fprintf(stderr,
                     "marker %d%s: a d x, w s z, e q y; 1 2 3 4 step 1, 0.1, 0.01, 0.002 mm; t take, n skip, x end\n",
                     marker, focus ? " (bring it into focus too)" : "");
        for (;;) {
            switch (next()) {
                case 'a': moves.by(0, -step_); break;
                case 'd': moves.by(0, step_); break;
                case 's': moves.by(2, -step_); break;
                case 'w': moves.by(2, step_); break;
                case 'e': moves.by(1, step_); break;
                case 'q': moves.by(1, -step_); break;
                case '1': step_ = 1e-3; break;
                case '2': step_ = 1e-4; break;
                case '3': step_ = 1e-5; break;
                case '4': step_ = 2e-6; break;
                case 't': return Word::taken;
                case 'n': return Word::skipped;
                case 'x': return Word::stopped;
                default: break;
            }
        }
    }

private:
    char next() {
        if (!terminal_) {
            return at_ < script_.size() ? script_[at_++] : 'x';
        }
        for (;;) {
            if (const auto key = terminal_->next()) {
                return *key;
            }
            if (stop_requested()) {
                throw Interrupted();
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
    }

    std::string script_;
    std::size_t at_ = 0;
    std::unique_ptr<TerminalKeys> terminal_;
    double step_ = 1e-4;
};

/// A pendant, with the keys of `verify record` beside it where there is a terminal.
class PendantPerson : public Operator {
public:
    PendantPerson(const PendantWords& words, CellClient& client)
        : client_(&client), input_(pendant_input(words, port_, [&client] { return client.now(); })) {}
    Word align(JogMoves& moves, int marker, bool focus) override {
        std::fprintf(stderr, "marker %d%s: Probe-Z or Enter takes, Safe-Z or n skips, Reset or q ends\n", marker,
                     focus ? " (bring it into focus too)" : "");
        for (;;) {
            const auto key = input_->next();
            if (!key) {
                if (input_->ended()) {
                    return Word::stopped;
                }
                client_->pump_until([] { return false; }, kWait);
                const auto& actual = client_->status()->actual;
                input_->show({actual[0] / kWireUnitsPerMetre * 1e3, actual[1] / kWireUnitsPerMetre * 1e3,
                              actual[2] / kWireUnitsPerMetre * 1e3});
                continue;
            }
            switch (key->action) {
                case RecordAction::jog: jog(moves, *key); break;
                case RecordAction::step: step_ = key->step; break;
                case RecordAction::record: return Word::taken;
                case RecordAction::skip: return Word::skipped;
                case RecordAction::quit: return Word::stopped;
                case RecordAction::undo: std::fprintf(stderr, "what was taken stays; run again to go on\n"); break;
                case RecordAction::help: std::fprintf(stderr, "%s\n", kRecordHelp); break;
            }
        }
    }

private:
    void jog(JogMoves& moves, const RecordKey& key) {
        try {
            moves.by(index(key.axis), key.sign * (key.step > 0.0 ? key.step : step_),
                     [this] { return input_->stops(); });
        } catch (const CellRefused& refused) {
            std::fprintf(stderr, "%s\n", refused.what());
        }
    }

    CellClient* client_;
    std::unique_ptr<pendant::PendantPort> port_;
    std::unique_ptr<RecordInput> input_;
    double step_ = 1e-4;
};

struct LogRow {
    PointedMarker marker;
    int looks = 1;
};

std::vector<LogRow> read_log(const std::filesystem::path& file) {
    std::vector<LogRow> out;
    if (!std::filesystem::exists(file)) {
        return out;
    }
    const CsvTable csv = CsvTable::read(file);
    for (std::size_t i = 0; i < csv.size(); ++i) {
        const auto mm = [&](const char* name) { return csv.number(i, csv.column(name)) * 1e-3; };
        out.push_back({{csv.integer(i, csv.column("id")),
                        {mm("x_mm"), mm("y_mm"), mm("z_mm")},
                        mm("distance_mm"),
                        mm("distance_sigma_mm")},
                       csv.integer(i, csv.column("looks"))});
    }
    return out;
}

void write_log(const std::filesystem::path& file, const std::vector<LogRow>& rows) {
    std::string text = kLogHeader;
    for (const LogRow& row : rows) {
        const PointedMarker& m = row.marker;
        text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{}\n", m.id, m.reading.x * 1e3, m.reading.y * 1e3,
                            m.reading.z * 1e3, m.distance * 1e3, m.distance_sigma * 1e3, row.looks);
    }
    write_text_file(file, text);
}

PointingOutcome outcome_of(const PointingOptions& options, const CalibrationSet& set, const Target& target,
                           const std::vector<LogRow>& rows) {
    PointingOutcome out;
    const double across = options.pointing_um * 1e-6;
    const double along = options.focusing_um * 1e-6;
    bool sensed = true;
    for (const LogRow& row : rows) {
        out.markers.push_back(row.marker);
        sensed = sensed && row.marker.distance > 0.0;
    }
    const std::filesystem::path log = options.out / kLog;
    if (rows.size() < 3) {
        refuse(log, "has too few markers for a transform", std::to_string(rows.size()), "point at three or more");
    }
    out.focus_y = focus_of(set, rows.front().marker.reading).y;
    out.focus_sigma = along / std::sqrt(static_cast<double>(std::max(1, rows.front().looks)));
    if (sensed) {
        std::vector<DepthReading> readings;
        for (const PointedMarker& m : out.markers) {
            readings.push_back({m.id, focus_of(set, m.reading), m.distance, std::max(m.distance_sigma, 2e-6)});
        }
        out.depths = fit_step_depths(log, target, readings, out.focus_y);
    }
    std::string text = "id,x_mm,y_mm,z_mm,sigma_x_um,sigma_y_um,sigma_z_um\n";
    for (std::size_t i = 0; i < out.markers.size(); ++i) {
        Vec3 place = focus_of(set, out.markers[i].reading);
        double sigma_y = along;
        if (out.depths) {
            place.y = out.depths->depths[i].y;
            sigma_y = out.depths->depths[i].sigma;
        }
        const double least = std::max(across, 2.5e-6) * 1e6;
        text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.3f},{:.3f},{:.3f}\n", out.markers[i].id, place.x * 1e3,
                            place.y * 1e3, place.z * 1e3, least, std::max(sigma_y, 1e-6) * 1e6, least);
    }
    out.h_csv = options.out / "h.csv";
    write_text_file(out.h_csv, text);
    return out;
}

/// The target, and in the simulated cell the world that it stands in.
struct Scene {
    Target target;
    std::optional<std::filesystem::path> world;
};

Scene scene_of(const PointingOptions& options) {
    Scene scene;
    if (!is_simulated(options.link)) {
        if (!options.target) {
            refuse({}, "which target stands before the head is not said", {}, "give --target FILE");
        }
        scene.target = read_target(*options.target);
    } else {
        const std::filesystem::path folder = options.out / "mobile";
        const auto base = options.base_world.value_or(in_project("boards/sim/world/default/world.toml"));
        if (!std::filesystem::exists(folder / "target.toml") &&
            run_program(required_program(kSurvey), {"mobile", "--world", base.string(), "--out", folder.string(),
                                                    "--seed", std::to_string(options.seed)})
                    .exit_code != 0) {
            throw CellError(std::string(kSurvey) + " failed");
        }
        scene.world = folder / "world.toml";
        scene.target = read_target(options.target.value_or(folder / "target.toml"));
    }
    if (scene.target.kind != TargetKind::mobile || scene.target.markers.size() < 3) {
        refuse(options.target.value_or(std::filesystem::path{}), "is no mobile target with three markers or more",
               scene.target.id, "give a target of kind \"mobile\"");
    }
    return scene;
}

/// In this order: the first of each step in turn, so that a target that is left early still has all of them.
std::vector<TargetMarker> order_of(const Target& target, int wanted) {
    std::vector<TargetMarker> out = target.markers;
    if (wanted > 0 && out.size() > static_cast<std::size_t>(wanted)) {
        out.resize(static_cast<std::size_t>(wanted));
    }
    return out;
}

class Pointing {
public:
    Pointing(const PointingOptions& options, const CalibrationSet& set, const Scene& scene)
        : options_(options), set_(set), scene_(scene), rows_(read_log(options.out / kLog)) {}

    PointingOutcome run() {
        const auto markers = order_of(scene_.target, options_.markers);
        const bool all = std::ranges::all_of(markers, [this](const TargetMarker& m) { return done(m.id); });
        bool stopped = false;
        if (!all) {
            stopped = !point(markers);
        }
        PointingOutcome out = outcome_of(options_, set_, scene_.target, rows_);
        out.stopped = stopped;
        return out;
    }

private:
    [[nodiscard]] bool done(int id) const {
        return std::ranges::any_of(rows_, [id](const LogRow& row) { return row.marker.id == id; });
    }

    bool point(const std::vector<TargetMarker>& markers) {
        JogSession session({.link = options_.link, .world = scene_.world, .seed = options_.seed, .key = options_.key});
        std::unique_ptr<Operator> person;
        if (options_.pendant.asked()) {
            person = std::make_unique<PendantPerson>(options_.pendant, session.client());
        } else if (options_.keys || !scene_.world) {
            person = std::make_unique<KeyPerson>(options_.keys);
        } else {
            person = std::make_unique<SimulatedPerson>(options_, *scene_.world);
        }
        bool whole = false;
        session.run([&](JogMoves& moves) {
            guide_light(session.client());
            whole = all_markers(markers, moves, *person);
        });
        return whole;
    }

    bool all_markers(const std::vector<TargetMarker>& markers, JogMoves& moves, Operator& person) {
        const Vec3 zero{options_.at_mm[0] * 1e-3, options_.at_mm[1] * 1e-3, options_.at_mm[2] * 1e-3};
        std::size_t number = 0;
        for (const TargetMarker& marker : markers) {
            ++number;
            if (done(marker.id)) {
                continue;
            }
            std::fprintf(stderr, "marker %d (%zu of %zu)\n", marker.id, number, markers.size());
            // With the sensor, y stays where the first marker was in focus.
            const bool first = rows_.empty();
            const bool sensed = !first && rows_.front().marker.distance > 0.0;
            Vec3 rough = zero + marker.place;
            rough.y = sensed ? rows_.front().marker.reading.y : rough.y;
            moves.to(rough);
            const Operator::Word word = person.align(moves, marker.id, !sensed);
            if (word == Operator::Word::stopped) {
                return false;
            }
            if (word == Operator::Word::skipped) {
                continue;
            }
            take(marker.id, moves, person, first);
        }
        return true;
    }

    void take(int id, JogMoves& moves, Operator& person, bool first) {
        LogRow row{{id, moves.place(), 0.0, 0.0}, 1};
        if (first) {
            // The focus is common to all markers: looked for again and again.
            double sum = row.marker.reading.y;
            for (; row.looks < options_.looks; ++row.looks) {
                if (person.align(moves, id, true) != Operator::Word::taken) {
                    break;
                }
                sum += moves.place().y;
            }
            const Vec3 now = moves.place();
            moves.to({now.x, sum / row.looks, now.z});
            row.marker.reading = moves.place();
        }
        if (const auto distance = moves.distance(0, kSensorSamples)) {
            row.marker.distance = distance->mean;
            row.marker.distance_sigma = distance->sigma;
        }
        rows_.push_back(row);
        write_log(options_.out / kLog, rows_);
    }

    const PointingOptions& options_;
    const CalibrationSet& set_;
    const Scene& scene_;
    std::vector<LogRow> rows_;
};

}  // namespace

Vec3 focus_of(const CalibrationSet& set, const Vec3& reading) {
    const AxesRecord axes = set.axes.value_or(AxesRecord{});
    const Vec3& q = reading;
    return {q.x * (1.0 + axes.scale[0]) + axes.squareness_xy * q.y + axes.squareness_xz * q.z,
            q.y * (1.0 + axes.scale[1]) + axes.squareness_yz * q.z, q.z * (1.0 + axes.scale[2])};
}

PointingOutcome run_pointing(const PointingOptions& options) {
    make_folder(options.out);
    const CalibrationSet set = options.calibration ? read_calibration(*options.calibration) : CalibrationSet{};
    const Scene scene = scene_of(options);
    return Pointing(options, set, scene).run();
}

}  // namespace sc::host::cli
