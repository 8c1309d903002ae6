// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/formats/mesh.hpp"
#include "host/formats/part.hpp"
#include "host/formats/scan.hpp"
#include "host/inspection/alignment.hpp"
#include "host/inspection/allowance.hpp"
#include "host/inspection/borrowing.hpp"
#include "host/inspection/datum_line.hpp"

namespace sc::host {

enum class AlignBy : std::uint8_t { automatic, best_fit, references, features };
[[nodiscard]] std::string_view name_of(AlignBy by) noexcept;

struct InspectionRequest {
    AlignBy align = AlignBy::automatic;      ///< automatic: references where the part has six, else best fit
    std::vector<std::string> features = {};  ///< align by features: the ids of the faces that decide
    double least = 0.0;                      ///< metres, of every face, where there is no part
    bool borrow = true;
    BorrowOptions borrowing = {};
    std::optional<Rigid<frame::W, frame::W>> what_if = {};  ///< allowance at this motion besides
    std::optional<Placement> start = {};                    ///< known placement: no search
    bool open_allowed = false;                              ///< CAD that is not closed is not refused
    bool lines = false;                                     ///< cut the part's datum planes with the scan
    unsigned threads = 0;
    std::function<void(std::string_view)> progress = {};  ///< called before each step
};

struct Inspection {
    std::vector<std::string> notes;  ///< for a person: what was unusual
    std::size_t points = 0;
    bool closed = true;
    std::size_t shells = 0;
    FaceMap map;
    AlignBy aligned_by = AlignBy::best_fit;
    Fit fit;
    std::vector<ReferenceUse> references;
    Placement w_from_c;
    double coverage = 0.0;  ///< of the CAD surface, seen by the scan
    AllowancePlan plan;
    OverFaces over;
    AllowanceReport before;
    AsCast as_cast;
    std::optional<Borrowing> borrowing;
    std::optional<AllowanceReport> after;
    std::optional<AllowanceReport> what_if;
    std::vector<DatumLine> lines;  ///< in w, as the part finally lies
    /// With the borrowing, if there was one: what lines and verdict are for.
    [[nodiscard]] Placement final_w_from_c() const { return borrowing ? borrowing->motion * w_from_c : w_from_c; }
    std::vector<std::pair<std::string, double>> seconds;  ///< of each step
};

/// From CAD and scan to allowance and borrowing. `part` may be null: then every face asks for `request.least`. Throws
/// InputError for a CAD model that is not closed or does not have the part's features, InspectionError for a scan of
/// another size, another part or too little of it.
[[nodiscard]] Inspection inspect(const DistanceField& field, std::span<const Vec3> scan, const Part* part,
                                 const InspectionRequest& request);

/// Which faces stop the smallest margin, and how much each pushes; largest first. Shares sum to at most 1.
struct Conflict {
    std::string id;
    double share = 0.0;
    double asked = 0.0;  ///< metres
    double best = 0.0;   ///< metres of metal it has at the optimum
};
[[nodiscard]] std::vector<Conflict> conflicts(const Inspection& inspection);

/// Throws InspectionError if a scan is 25.4 or 1000 times too large or small, or of no size like the CAD model's.
void check_size(const DistanceField& field, std::span<const Vec3> scan);

}  // namespace sc::host
