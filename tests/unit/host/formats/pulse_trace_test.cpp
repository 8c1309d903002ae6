// SPDX-License-Identifier: Apache-2.0
#include "host/formats/pulse_trace.hpp"

#include "tests/unit/host/formats/support.hpp"

namespace sc::host {
namespace {

using test::expect_refusal;
using test::TempDir;

const std::string kHeader =
    R"({"axis":{"point_m":[-0.25,-0.47,0],"direction":[0,0,1.0000001]},)"
    R"("errors":[{"name":"galvo_offset_x","value":35.0,"unit":"um","compensated_by":"calibration"},)"
    R"({"name":"runout","value":0.5,"unit":"um","compensated_by":null}],"machine":{"name":"ref"}})";

std::string head(const std::array<char, 8>& magic, const std::string& header) {
    std::string out(magic.begin(), magic.end());
    const auto size = static_cast<std::uint32_t>(header.size());
    for (unsigned shift = 0; shift < 32; shift += 8) {
        out += static_cast<char>((size >> shift) & 0xFFU);
    }
    return out + header;
}

template <std::size_t Size, class Record>
std::string packed(const Record& record) {
    std::array<std::uint8_t, Size> bytes{};
    trace::pack(record, bytes);
    return {bytes.begin(), bytes.end()};
}

trace::PulseRecord pulse(std::int64_t i) {
    return {.t_ns = 1000 * i,
            .place_pm = {i, -2 * i, 3},
            .table_pm = {4, 5, -6},
            .defocus_pm = -i,
            .c_ndeg = -90'000'000'000,
            .energy_nj = 300'000,
            .hit = 1};
}

std::string pulses(std::int64_t count) {
    std::string out = head(trace::kPulseMagic, kHeader);
    for (std::int64_t i = 0; i < count; ++i) {
        out += packed<trace::kPulseRecordSize>(pulse(i));
    }
    return out;
}

trace::SampleRecord sample(std::int64_t tick, std::uint16_t frames) {
    trace::SampleRecord out;
    out.tick = tick;
    out.set_point = {1, -2, 3, -4};
    out.state = 9;
    out.galvo_frames = frames;
    return out;
}

TEST(PulseTrace, ReadsHeaderAndRecords) {
    const TempDir dir;
    const PulseTrace trace = read_pulse_trace(dir.write("p", pulses(1000)));
    EXPECT_EQ(trace.header.axis.point.v, (Vec3{-0.25, -0.47, 0.0}));
    EXPECT_NEAR(norm(trace.header.axis.direction.v), 1.0, 1e-15);
    ASSERT_EQ(trace.header.errors.size(), 2U);
    EXPECT_EQ(trace.header.errors[0], (KnownError{"galvo_offset_x", 35.0, "um", "calibration"}));
    EXPECT_EQ(trace.header.errors[1], (KnownError{"runout", 0.5, "um", ""}));
    EXPECT_EQ(trace.header.machine, R"({"name":"ref"})");
    EXPECT_EQ(trace.header.json, kHeader);
    ASSERT_EQ(trace.pulses.size(), 1000U);
    EXPECT_EQ(trace.pulses[999].t_ns, 999'000);
    EXPECT_EQ(trace.pulses[999].place_pm, pulse(999).place_pm);
    EXPECT_EQ(trace.pulses[999].c_ndeg, -90'000'000'000);
}

TEST(PulseTrace, MayBeWithoutPulsesAndWithABareHeader) {
    const TempDir dir;
    const PulseTrace trace = read_pulse_trace(dir.write("p", head(trace::kPulseMagic, "{}")));
    EXPECT_TRUE(trace.pulses.empty());
    EXPECT_TRUE(trace.header.errors.empty());
    EXPECT_EQ(trace.header.axis, AxisLine{});
}

TEST(PulseTrace, NamesTheByteWhereItWasCut) {
    const TempDir dir;
    const std::string whole = pulses(3);
    const std::size_t start = whole.size() - 3 * trace::kPulseRecordSize;
    for (std::size_t size = 0; size < whole.size(); size += size < 16 ? 1 : 5) {
        const auto path = dir.write("p", std::string_view(whole).substr(0, size));
        if (size >= start && (size - start) % trace::kPulseRecordSize == 0) {
            EXPECT_EQ(read_pulse_trace(path).pulses.size(), (size - start) / trace::kPulseRecordSize);
            continue;
        }
        const std::size_t last = size < 8       ? 0
                                 : size < 12    ? 8
                                 : size < start ? 12
                                                : size - (size - start) % trace::kPulseRecordSize;
        std::size_t seen = 0;
        expect_refusal(
            [&] { for_each_pulse(path, [&seen](const trace::PulseRecord&) { ++seen; }); },
            {.file = path.string(), .value = "byte offset " + std::to_string(last), .problem = "ends within"});
        EXPECT_EQ(seen, size < start ? 0 : (size - start) / trace::kPulseRecordSize);
    }
}

TEST(PulseTrace, RefusesOtherFiles) {
    const TempDir dir;
    const auto bad = [&dir](const std::string& bytes, const std::string& problem) {
        const auto path = dir.write("p", bytes);
        try {
            static_cast<void>(read_pulse_trace(path));
            ADD_FAILURE() << problem;
        } catch (const InputError& error) {
            EXPECT_NE(error.problem().find(problem), std::string::npos) << error.what();
            EXPECT_EQ(error.file(), path.string());
        }
    };
    bad(head(trace::kSampleMagic, "{}"), "another kind of file");
    bad("PNG\r\n and more", "another kind of file");
    bad(head(trace::kPulseMagic, "{"), "cannot be understood");
    bad(head(trace::kPulseMagic, R"({"axis":{"point_m":[0,0]}})"), "cannot be understood");
    bad(head(trace::kPulseMagic, R"({"axis":{"point_m":[0,0,0],"direction":[0,0,0]}})"), "cannot be understood");
    bad(head(trace::kPulseMagic, R"({"errors":[{"name":1}]})"), "cannot be understood");
    bad(head(trace::kPulseMagic, R"({"errors":7})"), "cannot be understood");
    bad(head(trace::kPulseMagic, "[]"), "cannot be understood");
    bad(std::string(trace::kPulseMagic.begin(), trace::kPulseMagic.end()) + "\xff\xff\xff\xff", "impossible length");
    expect_refusal([] { static_cast<void>(read_pulse_trace("no/trace")); },
                   {.file = "no/trace", .problem = "no such file"});
}

TEST(SampleTrace, StreamsTicksWithTheirGalvoFrames) {
    const TempDir dir;
    std::string bytes = head(trace::kSampleMagic, kHeader) + packed<trace::kSampleRecordSize>(sample(1, 0)) +
                        packed<trace::kSampleRecordSize>(sample(2, 100));
    for (std::int64_t i = 0; i < 100; ++i) {
        bytes += packed<trace::kGalvoSampleSize>(trace::GalvoSample{i, -i});
    }
    bytes += packed<trace::kSampleRecordSize>(sample(3, 0));
    std::vector<std::int64_t> ticks;
    std::vector<std::size_t> frames;
    const auto path = dir.write("s", bytes);
    for_each_sample(path, [&](const trace::SampleRecord& record, std::span<const trace::GalvoSample> galvo) {
        ticks.push_back(record.tick);
        frames.push_back(galvo.size());
        if (!galvo.empty()) {
            EXPECT_EQ(galvo[99].x_pm, 99);
            EXPECT_EQ(galvo[99].z_pm, -99);
        }
    });
    EXPECT_EQ(ticks, (std::vector<std::int64_t>{1, 2, 3}));
    EXPECT_EQ(frames, (std::vector<std::size_t>{0, 100, 0}));

    const auto cut = dir.write("cut", std::string_view(bytes).substr(0, bytes.size() - trace::kSampleRecordSize - 1));
    EXPECT_THROW(for_each_sample(cut, [](const auto&, auto) {}), InputError);
}

TEST(SampleTrace, RefusesAnImpossibleNumberOfFrames) {
    const TempDir dir;
    const auto path = dir.write("s", head(trace::kSampleMagic, "{}") + packed<trace::kSampleRecordSize>(sample(1, 99)));
    expect_refusal([&] { for_each_sample(path, [](const auto&, auto) {}); },
                   {.file = path.string(), .value = "99", .problem = "impossible number of galvo frames"});
}

}  // namespace
}  // namespace sc::host
