// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/faults/fault_oracle.hpp"
#include "tests/bench/faults/faulty_cell.hpp"

namespace sc::faults {

/// What came of a combination.
struct Row {
    Combination combination;
    Verdict verdict;
    std::string excluded;  ///< why it cannot be; then nothing was run
    std::string ended;     ///< state at the end
    int code = 0;          ///< first fault
};

struct CampaignOptions {
    bool brief = false;          ///< fewer states, for ./test and for the mutants
    bool stop_at_first = false;  ///< the first violation ends it
    unsigned rule = 0;           ///< rule that is taken out once the reference job is known, 0: none
    std::vector<Burn> path;      ///< of the undisturbed job, where it is known
    int jobs = 2;                ///< processes at a time
    std::function<void(const Row&)> on_row;
};

/// Tells the phases of the job as it goes, each once.
class PhaseFinder {
public:
    /// The phase that begins in this instant; empty: none does. `stroke` is the cruise of the mirrors.
    [[nodiscard]] std::string_view step(const Instant& instant, const std::array<double, 4>& command);

private:
    [[nodiscard]] std::string_view look(const Instant& instant, const std::array<double, 4>& command);
    int resting_ = 0;
    int steady_ = 0;
    int strokes_ = 0;
    std::vector<std::string_view> seen_;
};

/// Runs the cell from power-up through all its states, once undisturbed and once with a fork of the process at each
/// state and phase for each fault: each combination begins at exactly the same moment.
class Campaign {
public:
    explicit Campaign(CampaignOptions options) : options_(std::move(options)) {}

    std::vector<Row> run();
    /// What the undisturbed job burns; after run().
    [[nodiscard]] const std::vector<Burn>& path() const { return path_; }

private:
    struct Child {
        int pid = 0;
        int pipe = -1;
        Row row;
    };

    void scout();
    void visit();
    void visit_jobs();
    void visit_stops();
    void at(const std::string& phase);
    void run_job(link::Verb verb, State done, bool visited);
    void to_moment(link::Verb verb, const std::string& phase);
    void judge_resumed(std::size_t from);
    void stop_at(const std::string& phase, const std::string& label);
    void hand_over(const std::string& fault, const std::string& phase);
    Row suffer(Row row);
    void reap(std::size_t most);
    void keep(Row row);
    [[nodiscard]] bool over() const { return options_.stop_at_first && violated_; }

    CampaignOptions options_;
    std::unique_ptr<FaultyCell> cell_;
    std::vector<Burn> path_;
    std::vector<Child> children_;
    std::vector<Row> rows_;
    bool violated_ = false;
};

/// Faults of the list, in its order.
[[nodiscard]] std::vector<std::string> fault_names(bool brief);

}  // namespace sc::faults
