// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
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
    bool brief = false;        ///< fewer states, for ./test and for the mutants
    bool stop_at_first = false;  ///< the first violation ends it
    unsigned rule = 0;         ///< rule that is taken out once the reference job is known, 0: none
    int jobs = 2;              ///< processes at a time
    std::function<void(const Row&)> on_row;
};

/// Runs the cell from power-up through all its states, once undisturbed and once with a fork of the process at each
/// state and phase for each fault: each combination begins at exactly the same moment.
class Campaign {
public:
    explicit Campaign(CampaignOptions options) : options_(std::move(options)) {}

    std::vector<Row> run();

private:
    using Moments = std::multimap<int, std::string>;
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
    void run_job(link::Verb verb, const Moments& moments, State done);
    void to_moment(link::Verb verb, const std::string& phase);
    void stop_at(const std::string& phase, const std::string& label);
    void hand_over(const std::string& fault, const std::string& phase);
    [[nodiscard]] static Moments moments_of(const std::vector<Instant>& instants, std::size_t first);
    Row suffer(Row row);
    void reap(std::size_t most);
    void keep(Row row);
    [[nodiscard]] bool over() const { return options_.stop_at_first && violated_; }

    CampaignOptions options_;
    std::unique_ptr<FaultyCell> cell_;
    std::vector<Burn> path_;
    Moments burning_;
    Moments tracing_;
    std::vector<Child> children_;
    std::vector<Row> rows_;
    bool violated_ = false;
};

/// Faults of the list, in its order.
[[nodiscard]] std::vector<std::string> fault_names(bool brief);

}  // namespace sc::faults
