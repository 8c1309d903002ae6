// SPDX-License-Identifier: Apache-2.0
#include "host/registration/match.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "tests/unit/host/registration/cell.hpp"

namespace sc::host {
namespace {

using Cloud = std::vector<SeenMarker>;

Cloud random_cloud(int count, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> even(-0.2, 0.2);
    Cloud out;
    for (int k = 0; k < count; ++k) {
        const double x = even(random);
        const double y = even(random);
        out.push_back({0, k, {x, y, 0.5 * even(random)}, {}});
    }
    return out;
}

Cloud moved(const Cloud& cloud) {
    Cloud out = cloud;
    const Mat3 r = test::turn(1.1, {0.3, -0.7, 0.4});
    for (SeenMarker& m : out) {
        m.place = r * m.place + Vec3{0.3, -0.1, 0.9};
    }
    return out;
}

TEST(Match, MarkersAreFoundAgainWithoutNumbersThoughSomeAreMissingAndOthersNew) {
    const Cloud a = random_cloud(24, 1);
    Cloud b = moved(a);
    std::ranges::reverse(b);
    b.resize(12);  // ids 23 to 12
    const Cloud others = random_cloud(3, 9);
    for (std::size_t k = 0; k < 3; ++k) {
        b.push_back({0, 900, others[k].place + Vec3{0.2, 0.1, 0.7}, {}});
    }
    const auto matches = match_by_distances(a, b, 5e-5);
    ASSERT_TRUE(matches) << matches.error();
    ASSERT_EQ(matches->size(), 12U);
    for (const MarkerMatch& m : *matches) {
        EXPECT_EQ(m.a, 23 - m.b);
    }
}

TEST(Match, FiveInCommonSuffice) {
    const Cloud a = random_cloud(12, 2);
    Cloud b = moved(a);
    const Cloud others = random_cloud(12, 3);
    for (std::size_t k = 5; k < b.size(); ++k) {
        b[k].place = others[k].place;
    }
    const auto matches = match_by_distances(a, b, 5e-5);
    ASSERT_TRUE(matches) << matches.error();
    EXPECT_EQ(matches->size(), 5U);
}

TEST(Match, RegularPatternsAndUnrelatedCloudsAreRefused) {
    Cloud square;
    for (int k = 0; k < 4; ++k) {
        square.push_back({0, k, {0.1 * (k % 2), 0.1 * (k / 2), 0.0}, {}});
    }
    const auto regular = match_by_distances(square, moved(square), 5e-5);
    ASSERT_FALSE(regular);
    EXPECT_NE(regular.error().find("regular"), std::string::npos);
    const auto unrelated = match_by_distances(random_cloud(10, 4), random_cloud(10, 5), 5e-5);
    ASSERT_FALSE(unrelated);
    EXPECT_NE(unrelated.error().find("four"), std::string::npos);
    const auto few = match_by_distances(random_cloud(3, 4), random_cloud(10, 4), 5e-5);
    ASSERT_FALSE(few);
    EXPECT_NE(few.error().find("fewer than four"), std::string::npos);
}

TEST(Match, AMirroredCloudIsNotMatchedAndUnitsAreNamed) {
    const Cloud a = random_cloud(10, 6);
    Cloud b = moved(a);
    EXPECT_EQ(misfit_reason(a, b), "");
    for (SeenMarker& m : b) {
        m.place.y = -m.place.y;
    }
    EXPECT_FALSE(match_by_distances(a, b, 5e-5));
    EXPECT_NE(misfit_reason(a, b).find("left-handed"), std::string::npos);
    for (SeenMarker& m : b) {
        m.place = 25.4 * m.place;
    }
    EXPECT_NE(misfit_reason(b, a).find("mm for inch"), std::string::npos) << misfit_reason(b, a);
    b[3].place = {};
    EXPECT_NE(misfit_reason(b, a).find("units"), std::string::npos);  // one wrong marker hides nothing
}

}  // namespace
}  // namespace sc::host
