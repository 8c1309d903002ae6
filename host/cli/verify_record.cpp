// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/bridge/open_transport.hpp"
#include "host/bridge/session.hpp"
#include "host/bridge/stop.hpp"
#include "host/calibration/transforms.hpp"
#include "host/cli/calibration_age.hpp"
#include "host/cli/failure.hpp"
#include "host/cli/jog_moves.hpp"
#include "host/cli/key_option.hpp"
#include "host/cli/record_keys.hpp"
#include "host/cli/verify.hpp"
#include "host/formats/error.hpp"
#include "host/formats/job.hpp"
#include "host/formats/table.hpp"
#include "host/path/face_places.hpp"

namespace sc::host::cli {
namespace {

constexpr const char* kExamples = R"(Examples:
  scribecell verify record --job examples/ras3dm/job.toml --out checked.csv --link tcp:127.0.0.1:7000
      goes to each marker of the job; a person jogs the beam onto the mark and presses Enter
  scribecell verify record --job my_job.toml --out checked.csv --link can:can0 --pendant
      with the wheel of a USB pendant; its key Probe-Z records
  scribecell verify record --job my_job.toml --out checked.csv --face 90
  scribecell verify record --job my_job.toml --out checked.csv --keys keys.txt
      the same with keys from a file, on the simulated cell
  scribecell verify --table checked.csv
      what the table says

Run again with the same --out, it goes on with the markers that are missing. Every marker is written at once, all or
nothing; Ctrl-C brings the cell to rest. The laser stays off; the guide laser is on where key and enclosure allow it.

Recorded is where the axes stand, with the squareness and scale of the calibration taken in; without its axis map.

Exit codes: 0 recorded, or stopped to go on later; 1 the cell failed; 2 bad input; 130 Ctrl-C.)";

constexpr double kSameAngle = 1e-3;  ///< degrees
constexpr double kClear = 100e-6;    ///< metres: y is surely retracted
constexpr double kSameMarker = 1e-6;
constexpr Nanoseconds kWait = std::chrono::milliseconds(20);

struct Words {
    std::string job;
    std::string table;
    std::string calibration;
    std::string out;
    std::string keys;
    std::string link = "sim:";
    std::vector<double> faces;
    LinkOptions link_options;
    PendantWords pendant;
    double step_mm = 0.1;
    bool home = false;
    bool accept_expired = false;
    bool json = false;
};

struct RecordPoint {
    double face_deg = 0.0;
    int no = 0;
    Point<frame::H> measured;
};

std::vector<RecordPoint> points_of(const Words& words, const Job& job, const CalibrationSet& set) {
    std::vector<RecordPoint> out;
    const VerificationTable table = !words.table.empty() ? read_table(words.table)
                                    : job.table.empty()  ? VerificationTable{}
                                                         : read_table(job.table);
    if (!words.table.empty()) {
        for (const TableRow& row : table.rows) {
            out.push_back({row.face_deg, row.no, row.measured});
        }
    } else {
        for (const JobFace& face : job.faces) {
            for (const MarkerPlace& marker : face_places(job, face, table, set, reference_machine(), false).markers) {
                out.push_back({face.angle_deg, marker.no, marker.place});
            }
        }
    }
    const auto unwanted = [&words](const RecordPoint& point) {
        return !words.faces.empty() &&
               std::ranges::none_of(words.faces, [&point](double face) { return same_face(face, point.face_deg); });
    };
    std::erase_if(out, unwanted);
    if (out.empty()) {
        throw InputError({.file = words.table.empty() ? words.job : words.table,
                          .problem = "has no markers to point at",
                          .action = "give a job with faces, or a table, and faces that it has"});
    }
    return out;
}

/// The table as it grows, in its file.
class Record {
public:
    Record(const std::filesystem::path& file, const std::vector<RecordPoint>& points) : file_(file) {
        table_.file = file;
        if (!std::filesystem::exists(file)) {
            return;
        }
        table_ = read_table(file);
        for (const TableRow& row : table_.rows) {
            const auto point = std::ranges::find_if(
                points, [&row](const RecordPoint& p) { return same_face(p.face_deg, row.face_deg) && p.no == row.no; });
            // Points of a face that was not asked for stay.
            if (point != points.end() && norm(point->measured.v - row.measured.v) > kSameMarker) {
                throw InputError({.file = file.string(),
                                  .line = row.line,
                                  .problem = "is of another table or calibration: this marker was measured elsewhere",
                                  .value = fmt::format("face {:.6g}, marker {}", row.face_deg, row.no),
                                  .action = "give another --out, or remove the file to begin again"});
            }
        }
    }
    [[nodiscard]] bool has(const RecordPoint& point) const {
        return std::ranges::any_of(table_.rows, [&point](const TableRow& row) {
            return same_face(point.face_deg, row.face_deg) && point.no == row.no;
        });
    }
    void add(const RecordPoint& point, const Vec3& truth) {
        table_.rows.push_back(
            {.line = 0, .face_deg = point.face_deg, .no = point.no, .measured = point.measured, .truth = {truth}});
        save();
    }
    /// The marker that was taken out; nothing if there was none.
    std::optional<TableRow> undo() {
        if (table_.rows.empty()) {
            return std::nullopt;
        }
        const TableRow last = table_.rows.back();
        table_.rows.pop_back();
        save();
        return last;
    }
    [[nodiscard]] std::size_t size() const { return table_.rows.size(); }

private:
    void save() const {
        if (table_.rows.empty()) {
            std::filesystem::remove(file_);
        } else {
            write_table(file_, table_);
        }
    }
    std::filesystem::path file_;
    VerificationTable table_;
};

/// The focus for readings q, and back (docs/frames.md, "Errors of the linear axes").
struct AxesModel {
    explicit AxesModel(const CalibrationSet& set) : inverse(compensation_of(set).axis_from_h) {
        if (set.axes) {
            const AxesRecord& a = *set.axes;
            forward = {{Vec3{1.0 + a.scale[0], a.squareness_xy, a.squareness_xz},
                        Vec3{0.0, 1.0 + a.scale[1], a.squareness_yz}, Vec3{0.0, 0.0, 1.0 + a.scale[2]}}};
        }
    }
    Mat3 forward;
    Mat3 inverse;
};

void check_reach(const std::vector<RecordPoint>& points, const AxesModel& model, const MachineConfig& machine) {
    for (const RecordPoint& point : points) {
        const Vec3 q = model.inverse * point.measured.v;
        for (std::size_t i = 0; i < 3; ++i) {
            if (q[i] < machine.axis.at(i).travel_min || q[i] > machine.axis.at(i).travel_max) {
                throw InputError({.problem = fmt::format("marker {} of face {:.6g} is out of the travel of {}",
                                                         point.no, point.face_deg, "XYZ"[i]),
                                  .value = fmt::format("{:.3f} mm", 1e3 * q[i]),
                                  .action = "check the table and the calibration"});
            }
        }
    }
}

class Recorder {
public:
    Recorder(CellClient& client, const MachineConfig& machine, const AxesModel& model, RecordInput& input,
             Record& record, double step)
        : client_(&client),
          moves_(client),
          retracted_(machine.y_retracted.si() + kClear),
          model_(model),
          input_(&input),
          record_(&record),
          step_(step) {}

    /// False: the person stopped.
    bool run(const std::vector<RecordPoint>& points) {
        std::set<std::size_t> skipped;
        std::size_t i = 0;
        while (i < points.size()) {
            if (record_->has(points[i]) || skipped.contains(i)) {
                ++i;
                continue;
            }
            const auto [next, on] = one(points, i, skipped);
            if (!on) {
                return false;
            }
            i = next;
        }
        return true;
    }

private:
    struct After {
        std::size_t next;
        bool on;
    };
    After one(const std::vector<RecordPoint>& points, std::size_t i, std::set<std::size_t>& skipped) {
        const RecordPoint& point = points[i];
        go(model_.inverse * point.measured.v, c_of_face(point.face_deg));
        std::fprintf(stderr, "face %.6g, marker %d (%zu of %zu): jog onto the mark, then Enter; ? for the keys\n",
                     point.face_deg, point.no, i + 1, points.size());
        while (true) {
            const auto key = input_->next();
            if (!key) {
                if (input_->ended()) {
                    return {i, false};
                }
                client_->pump_until([] { return false; }, kWait);
                show();
                continue;
            }
            switch (key->action) {
                case RecordAction::jog: jog(*key); break;
                case RecordAction::step:
                    step_ = key->step;
                    std::fprintf(stderr, "steps of %g mm\n", 1e3 * step_);
                    break;
                case RecordAction::record: {
                    const Vec3 truth = model_.forward * moves_.place();
                    record_->add(point, truth);
                    const Vec3 d = 1e3 * (point.measured.v - truth);
                    std::fprintf(stderr, "recorded: measured - true %+.4f %+.4f %+.4f mm\n", d.x, d.y, d.z);
                    return {i + 1, true};
                }
                case RecordAction::skip: skipped.insert(i); return {i + 1, true};
                case RecordAction::undo: {
                    const auto last = record_->undo();
                    if (!last) {
                        std::fprintf(stderr, "there is nothing to undo\n");
                        break;
                    }
                    std::fprintf(stderr, "face %.6g, marker %d is open again\n", last->face_deg, last->no);
                    return {0, true};
                }
                case RecordAction::help: std::fprintf(stderr, "%s\n", kRecordHelp); break;
                case RecordAction::quit: return {i, false};
            }
        }
    }
    void go(const Vec3& readings, double c_deg) {
        if (const auto now = moves_.reading(); std::abs(now[3] - c_deg) > kSameAngle) {
            moves_.to({now[0], retracted_, now[2]});
            moves_.turn_to(c_deg);
        }
        moves_.to(readings);
    }
    void show() {
        const auto& actual = client_->status()->actual;
        std::array<double, 3> mm{};
        for (std::size_t i = 0; i < mm.size(); ++i) {
            mm.at(i) = static_cast<double>(actual.at(i)) / kWireUnitsPerMetre * 1e3;
        }
        input_->show(mm);
    }
    void jog(const RecordKey& key) {
        try {
            moves_.by(index(key.axis), key.sign * (key.step > 0.0 ? key.step : step_),
                      [this] { return input_->stops(); });
        } catch (const CellRefused& refused) {
            std::fprintf(stderr, "%s\n", refused.what());  // the end of travel, say; the person goes another way
        }
    }

    CellClient* client_;
    JogMoves moves_;
    double retracted_;
    AxesModel model_;
    RecordInput* input_;
    Record* record_;
    double step_;
};

std::unique_ptr<RecordInput> input_of(const Words& words) {
    if (!words.keys.empty()) {
        return std::make_unique<ScriptInput>(words.keys);
    }
    auto keyboard = std::make_unique<KeyboardInput>();
    if (keyboard->ended()) {
        throw InputError({.problem = "there is no terminal for a person's keys",
                          .action = "run it in a terminal, or give --keys FILE"});
    }
    return keyboard;
}

int report(const Words& words, const Record& record, const std::vector<RecordPoint>& points, bool all) {
    const auto open = static_cast<std::size_t>(
        std::ranges::count_if(points, [&record](const RecordPoint& point) { return !record.has(point); }));
    if (words.json) {
        const nlohmann::ordered_json json{{"format", "scribecell-verify-record"},
                                          {"version", 1},
                                          {"out", words.out},
                                          {"recorded", record.size()},
                                          {"open", open},
                                          {"stopped", !all}};
        std::printf("%s\n", json.dump(2).c_str());
    } else {
        std::printf("%s\n", fmt::format("{}: {} markers recorded, {} open{}", words.out, record.size(), open,
                                        open > 0 ? "; run again to go on" : "")
                                .c_str());
    }
    return 0;
}

int run(const Words& words) {
    if (words.job.empty() == words.table.empty()) {
        throw InputError({.problem = "it is not said which markers", .action = "give --job or --table"});
    }
    Job job;
    CalibrationSet set;
    if (!words.job.empty()) {
        job = read_job(words.job);
    }
    if (const std::filesystem::path file = words.calibration.empty() ? job.calibration.string() : words.calibration;
        !file.empty()) {
        set = read_calibration(file);
        check_age(set, words.accept_expired);
    }
    const std::vector<RecordPoint> points = points_of(words, job, set);
    Record record(words.out, points);
    std::unique_ptr<pendant::PendantPort> port;
    std::unique_ptr<RecordInput> input = words.pendant.asked() ? nullptr : input_of(words);
    const AxesModel model(set);
    if (std::ranges::all_of(points, [&record](const RecordPoint& point) { return record.has(point); })) {
        return report(words, record, points, true);
    }
    install_stop_signals();
    const auto transport = open_transport(words.link, words.link_options);
    CellClient client(*transport, client_options(words.link_options, 3));
    client.set_stop_check(stop_requested);
    client.connect();
    if (!input) {
        input = pendant_input(words.pendant, port, [&client] { return client.now(); });
    }
    const MachineConfig machine = client.read_config();
    check_reach(points, model, machine);
    SessionOptions options;
    options.on_step = [](const std::string& what) { std::fprintf(stderr, "%s\n", what.c_str()); };
    Session session(client, options);
    bool all = false;
    try {
        session.clear();
        if ((client.status()->flags & link::kFlagHomed) == 0 && !words.home && !is_simulated(words.link)) {
            throw InputError({.problem = "the axes are not homed", .action = "add --home to home all of them first"});
        }
        session.enable_and_home();
        guide_light(client);
        all = Recorder(client, machine, model, *input, record, 1e-3 * words.step_mm).run(points);
    } catch (const std::exception&) {
        session.make_safe();
        throw;
    }
    session.make_safe();
    return report(words, record, points, all);
}

}  // namespace

void add_verify_record(CLI::App& verify, int& exit_code) {
    CLI::App* sub = verify.add_subcommand("record", "Point the beam at each marker by hand, and record where it is.");
    sub->footer(kExamples);
    const auto words = std::make_shared<Words>();
    sub->add_option("--job", words->job, "whose markers")->type_name("FILE.toml");
    sub->add_option("--table", words->table, "or the measured places of a verification table")->type_name("FILE.csv");
    sub->add_option("--calibration", words->calibration, "set, in place of the job's own")->type_name("FILE");
    sub->add_option("--out", words->out, "the table; goes on where it is")->type_name("FILE.csv")->required();
    sub->add_option("--face", words->faces, "this face alone, degrees; may be given again")->type_name("DEG");
    sub->add_option("--keys", words->keys, "keys from a file in place of the keyboard")->type_name("FILE");
    add_pendant_options(*sub, words->pendant);
    sub->add_option("--step-mm", words->step_mm, "of a jog to begin with")
        ->check(CLI::Range(0.001, 10.0))
        ->capture_default_str();
    sub->add_option("--link", words->link, "the cell")->type_name("URL")->capture_default_str();
    sub->add_option("--capture", words->link_options.capture, "pcap file of all that passes over the link")
        ->type_name("FILE.pcap");
    add_key_option(*sub, words->link_options.key);
    sub->add_flag("--home", words->home, "home all axes first, if they are not");
    sub->add_flag("--accept-expired", words->accept_expired, "with a calibration of which a record has expired");
    sub->add_flag("--json", words->json, "one JSON object");
    sub->callback([words, &exit_code] { exit_code = guarded(words->json, [&words] { return run(*words); }); });
}

}  // namespace sc::host::cli
