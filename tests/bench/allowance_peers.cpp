// SPDX-License-Identifier: Apache-2.0
// scribecell-allowance-peers MESH [--points N] [--sign-points N] [--quick]: the distance engine against Embree (speed),
// against every triangle (exactness) and against CGAL (sign), in one run; one JSON object on stdout. Embree and CGAL
// take part where they were there when this was built.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "host/inspection/distance_field.hpp"
#include "host/inspection/space_order.hpp"
#include "tests/bench/allowance_workload.hpp"
#include "tests/bench/peers.hpp"

namespace sc::host::test {
namespace {

double seconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}
/// Of this thread's processor time: work of one thread, on a machine that others use too.
double thread_seconds(const std::function<void()>& work) {
    const auto now = [] {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}
/// The best of several, so that what else runs on the machine counts least; peers get the same.
double best_of(int runs, const std::function<void()>& work) {
    double best = 1e300;
    for (int i = 0; i < runs; ++i) {
        best = std::min(best, thread_seconds(work));
    }
    return best;
}

void compare_speed(nlohmann::ordered_json& out, const std::string& name, const TriangleMesh& mesh,
                   const std::vector<Vec3>& random, int runs) {
    std::vector<Vec3> sorted;
    for (const std::uint32_t i : space_order(random, 1)) {
        sorted.push_back(random[i]);
    }
    std::vector<Distance> distances(random.size());
    const auto million = static_cast<double>(random.size()) / 1e6;
    auto& entry = out[name];
    const DistanceField field(mesh);
    entry["triangles"] = mesh.triangles.size();
    entry["build_s"] = seconds([&] { const DistanceField again(mesh); });
    entry["megabytes"] = static_cast<double>(field.bytes()) / 1e6;
    const auto own = [&](const std::vector<Vec3>& places, const DistanceOptions& options) {
        return million / best_of(runs, [&] { field.measure(places, distances, options); });
    };
    for (const Simd simd : {Simd::baseline, Simd::avx2, Simd::avx512}) {
        if (available(simd)) {
            const std::string of(name_of(simd));
            entry["sorted_" + of] = own(sorted, {.threads = 1, .simd = simd, .sorted = true});
            entry["random_" + of] = own(random, {.threads = 1, .simd = simd, .sorted = false});
        }
    }
    entry["random_two_threads"] =
        million /
        seconds([&] { field.measure(random, distances, {.threads = 2, .simd = Simd::best, .sorted = false}); });
    std::vector<double> peer(random.size());
    if (const auto embree = make_embree(mesh)) {
        entry["embree_sorted"] = million / best_of(runs, [&] { embree(sorted, peer); });
        field.measure(sorted, distances, {.sorted = true});
        double worst = 0.0;
        for (std::size_t i = 0; i < sorted.size(); ++i) {
            worst = std::max(worst, std::abs(peer[i] - distances[i].value));
        }
        entry["embree_worst_difference_mm"] = 1e3 * worst;
        entry["embree_random"] = million / best_of(runs, [&] { embree(random, peer); });
    }
}

double worst_error(const TriangleMesh& mesh, const std::vector<Vec3>& places) {
    const DistanceField field(mesh);
    std::vector<Distance> distances(places.size());
    const std::vector<double> brute = brute_distances(mesh, places);
    double worst = 0.0;
    for (const Simd simd : {Simd::baseline, Simd::avx2, Simd::avx512}) {
        if (available(simd)) {
            field.measure(places, distances, {.simd = simd});
            for (std::size_t i = 0; i < places.size(); ++i) {
                worst = std::max(worst, std::abs(std::abs(distances[i].value) - brute[i]));
            }
        }
    }
    return 1e3 * worst;
}

/// Signs that differ from CGAL's, of places farther than 1e-9 mm from the surface.
std::size_t wrong_signs(const TriangleMesh& mesh, const std::vector<Vec3>& places) {
    const DistanceField field(mesh);
    std::vector<Distance> distances(places.size());
    field.measure(places, distances);
    const std::vector<bool> inside = make_cgal_sides(mesh)(places);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
        wrong += std::abs(distances[i].value) > 1e-12 && inside[i] != (distances[i].value < 0.0) ? 1U : 0U;
    }
    return wrong;
}

int run(int argc, char** argv) {
    std::size_t points = 1'000'000;
    std::size_t sign_points = 1'000'000;
    bool speed = true;
    bool exact = true;
    for (int i = 2; i < argc; ++i) {
        if (std::strcmp(argv[i], "--points") == 0 && i + 1 < argc) {
            points = std::stoul(argv[++i]);
        } else if (std::strcmp(argv[i], "--sign-points") == 0 && i + 1 < argc) {
            sign_points = std::stoul(argv[++i]);
        } else if (std::strcmp(argv[i], "--no-speed") == 0) {
            speed = false;
        } else if (std::strcmp(argv[i], "--no-exact") == 0) {
            exact = false;
        } else {
            std::fprintf(stderr, "unknown word: %s\n", argv[i]);
            return 2;
        }
    }
    // Four times the size, so that offsets of 2 to 4 mm are small beside the part.
    const TriangleMesh native = scaled(read_mesh(argv[1]).mesh, 4.0);
    const std::vector<Vec3> random = places_off(native, points, 2e-3, 4e-3, 2e-5, 1);
    nlohmann::ordered_json out;
    out["points"] = points;
    if (speed) {
        compare_speed(out, "native", native, random, 5);
        compare_speed(out, "211k", split_to(native, 210'584), random, 3);
        compare_speed(out, "951k", split_to(native, 951'020), random, 3);
    }
    if (exact) {
        out["exact_error_mm"] =
            std::max(worst_error(native, random), worst_error(native, places_at_edges(native, points / 10, 5e-5, 2)));
    }
    if (make_cgal_sides(native) && sign_points > 0) {
        std::size_t wrong = wrong_signs(native, places_off(native, sign_points / 2, -4e-3, 4e-3, 2e-5, 3));
        wrong += wrong_signs(native, places_at_edges(native, sign_points / 4, 5e-5, 4));
        wrong += wrong_signs(native, places_at_edges(native, sign_points - sign_points / 2 - sign_points / 4, 2e-3, 5));
        out["sign_points"] = sign_points;
        out["wrong_signs"] = wrong;
    }
    std::printf("%s\n", out.dump(2).c_str());
    return 0;
}

}  // namespace
}  // namespace sc::host::test

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "give a mesh\n");
        return 2;
    }
    try {
        return sc::host::test::run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
