// SPDX-License-Identifier: Apache-2.0
#include "firmware/recording/io_image.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace sc::recording {
namespace {

DriveFrame frame(unsigned n) {
    DriveFrame f;
    f.id = static_cast<std::uint16_t>(0x180 + n);
    f.size = static_cast<std::uint8_t>(n % 9);
    std::ranges::fill(f.data, static_cast<std::uint8_t>(0x30 + n));
    return f;
}

struct Fed {
    std::vector<std::uint8_t> link;
    std::vector<DriveFrame> drives;
    std::vector<std::uint8_t> source;
    std::array<std::vector<SensorByte>, kSensorBuses> sensors;
    ServoInputs inputs;

    Fed(std::size_t bytes, std::size_t frames) {
        for (std::size_t i = 0; i < bytes; ++i) {
            link.push_back(static_cast<std::uint8_t>(i * 7 + 1));
        }
        for (unsigned i = 0; i < frames; ++i) {
            drives.push_back(frame(i));
        }
        inputs.tick = -1234567890123;
        inputs.link_rx = link;
        inputs.drive_rx = drives;
        inputs.digital = {true, false, true, false, true, false, true, false, 0xB};
        inputs.galvo_status = 0xFDFD;
        inputs.guard_causes = 9;
        for (std::size_t i = 0; i < kSourceBytesPerTick; ++i) {
            source.push_back(static_cast<std::uint8_t>(0xA0 + i));
        }
        inputs.source_rx = source;
        inputs.encoders = {true, 20'000, {INT64_MIN, -1, 0, INT64_MAX}};
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            for (std::size_t i = 0; i < kSensorBytesPerTick; ++i) {
                sensors[bus].push_back({static_cast<std::uint8_t>(i * 3 + bus), static_cast<std::uint8_t>(i % 8),
                                        static_cast<std::uint16_t>(990 - i * 31)});
            }
            inputs.sensor_rx[bus] = sensors[bus];
        }
    }
};

std::unique_ptr<ServoOutputs> full_outputs(bool moving) {
    auto out = std::make_unique<ServoOutputs>();
    out->link_tx_size = out->link_tx.size();
    std::ranges::fill(out->link_tx, std::uint8_t{0xA5});
    out->drive_tx_size = out->drive_tx.size();
    for (unsigned i = 0; i < out->drive_tx.size(); ++i) {
        out->drive_tx[i] = frame(i);
    }
    out->set_point = {-1, 2, INT64_MIN, INT64_MAX};
    for (std::size_t k = 0; k < out->galvo.size(); ++k) {
        const auto n = static_cast<std::int64_t>(moving ? k : 0);
        out->galvo[k] = {n * 1'000'000'007, -n, static_cast<std::uint32_t>(n), 0xFFFFFU};
    }
    out->laser_size = out->laser.size();
    std::int64_t n = 1;
    for (LaserRun& run : out->laser) {
        run = {n << 40, -n, static_cast<std::int32_t>(-n), static_cast<std::uint16_t>(n), 3, 200};
        ++n;
    }
    out->pulses_size = out->pulses.size();
    for (PathPulse& pulse : out->pulses) {
        pulse = {7, 2, 99, static_cast<std::uint32_t>(n), n << 30, {n, -n, n << 44}, n * 1000};
        ++n;
    }
    out->source_tx_size = out->source_tx.size();
    std::ranges::fill(out->source_tx, std::uint8_t{0x5A});
    for (SensorTransmission& sent : out->sensor_tx) {
        std::ranges::fill(sent.bytes, static_cast<std::uint8_t>(0x11 + n));
        sent.size = kSensorTransmissionBytes;
        sent.delay_ns = 999'999;
    }
    out->digital = {true, false, true, false, true, true};
    out->clear_power = true;
    out->laser[175].latch_ns = 6'250;
    out->gate_allowed = true;
    out->state = 9;
    out->faults = 1ULL << 63U;
    return out;
}

TEST(IoImage, InputsComeBackAsTheyWere) {
    for (const std::size_t frames : {std::size_t{0}, std::size_t{5}, kDriveFramesPerTick}) {
        const Fed fed(frames * 42, frames);
        std::vector<std::uint8_t> bytes(kInputsImageCapacity);
        const std::size_t size = pack(fed.inputs, bytes);
        ASSERT_GT(size, 0U);
        StoredInputs back;
        ASSERT_TRUE(unpack(std::span(bytes).first(size), back));
        EXPECT_EQ(back.inputs.tick, fed.inputs.tick);
        EXPECT_EQ(back.inputs.digital, fed.inputs.digital);
        EXPECT_EQ(back.inputs.galvo_status, fed.inputs.galvo_status);
        EXPECT_EQ(back.inputs.guard_causes, fed.inputs.guard_causes);
        EXPECT_TRUE(std::ranges::equal(back.inputs.link_rx, fed.inputs.link_rx));
        EXPECT_TRUE(std::ranges::equal(back.inputs.drive_rx, fed.inputs.drive_rx));
        EXPECT_TRUE(std::ranges::equal(back.inputs.source_rx, fed.inputs.source_rx));
        EXPECT_EQ(back.inputs.encoders, fed.inputs.encoders);
        for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
            EXPECT_TRUE(std::ranges::equal(back.inputs.sensor_rx[bus], fed.inputs.sensor_rx[bus]));
        }
    }
}

TEST(IoImage, TheLargestInputsFillTheCapacityAndLargerAreRefused) {
    std::vector<std::uint8_t> bytes(kInputsImageCapacity);
    EXPECT_EQ(pack(Fed(kLinkBytesPerTick, kDriveFramesPerTick).inputs, bytes), kInputsImageCapacity);
    EXPECT_EQ(pack(Fed(kLinkBytesPerTick + 1, 0).inputs, bytes), 0U);
    EXPECT_EQ(pack(Fed(0, kDriveFramesPerTick + 1).inputs, bytes), 0U);
    ServoInputs talkative;
    const std::vector<std::uint8_t> many(kSourceBytesPerTick + 1);
    talkative.source_rx = many;
    EXPECT_EQ(pack(talkative, bytes), 0U);
    for (std::size_t bus = 0; bus < kSensorBuses; ++bus) {
        ServoInputs babbling;
        const std::vector<SensorByte> more(kSensorBytesPerTick + 1);
        babbling.sensor_rx[bus] = more;
        EXPECT_EQ(pack(babbling, bytes), 0U);
    }
    bytes.pop_back();
    EXPECT_EQ(pack(Fed(kLinkBytesPerTick, kDriveFramesPerTick).inputs, bytes), 0U);
}

TEST(IoImage, OutputsComeBackAsTheyWere) {
    for (const bool moving : {false, true}) {
        const auto outputs = full_outputs(moving);
        std::vector<std::uint8_t> bytes(kOutputsImageCapacity);
        const std::size_t size = pack(*outputs, bytes);
        EXPECT_EQ(size == kOutputsImageCapacity, moving);
        const auto back = std::make_unique<ServoOutputs>();
        ASSERT_TRUE(unpack(std::span(bytes).first(size), *back));
        // The image of what came back is the same image, and a field that the image forgot would read as its default.
        std::vector<std::uint8_t> again(kOutputsImageCapacity);
        ASSERT_EQ(pack(*back, again), size);
        EXPECT_EQ(bytes, again);
        EXPECT_EQ(back->set_point, outputs->set_point);
        EXPECT_EQ(back->galvo[99].x_pm, outputs->galvo[99].x_pm);
        EXPECT_EQ(back->laser[175].change_ns256, outputs->laser[175].change_ns256);
        EXPECT_EQ(back->laser[175].power, outputs->laser[175].power);
        EXPECT_EQ(back->pulses[511].place_pm, outputs->pulses[511].place_pm);
        EXPECT_EQ(back->pulses[511].t_ns, outputs->pulses[511].t_ns);
        EXPECT_EQ(back->digital, outputs->digital);
        EXPECT_EQ(back->state, outputs->state);
        EXPECT_EQ(back->faults, outputs->faults);
        EXPECT_TRUE(back->gate_allowed);
        EXPECT_FALSE(back->cancel_laser);
        EXPECT_TRUE(back->clear_power);
        EXPECT_EQ(back->laser[175].latch_ns, outputs->laser[175].latch_ns);
        EXPECT_EQ(back->source_tx, outputs->source_tx);
        EXPECT_EQ(back->sensor_tx, outputs->sensor_tx);
    }
}

TEST(IoImage, AnythingButOneWholeImageIsRefused) {
    const Fed fed(20, 3);
    std::vector<std::uint8_t> bytes(kInputsImageCapacity);
    bytes.resize(pack(fed.inputs, bytes));
    StoredInputs inputs;
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        EXPECT_FALSE(unpack(std::span(bytes).first(size), inputs)) << size;
    }
    bytes.push_back(0);
    EXPECT_FALSE(unpack(bytes, inputs));

    std::vector<std::uint8_t> image(kOutputsImageCapacity);
    const auto outputs = full_outputs(true);
    ASSERT_EQ(pack(*outputs, image), image.size());
    const auto back = std::make_unique<ServoOutputs>();
    for (std::size_t size = 0; size < image.size(); size += 97) {
        EXPECT_FALSE(unpack(std::span(image).first(size), *back)) << size;
    }
    image[1] = 0xFF;  // a count of link bytes beyond the tick's
    EXPECT_FALSE(unpack(image, *back));
}

TEST(IoImage, ClearEmptiesWhatIsAppended) {
    const auto outputs = full_outputs(true);
    clear(*outputs);
    EXPECT_EQ(outputs->link_tx_size + outputs->drive_tx_size + outputs->laser_size + outputs->pulses_size, 0U);
    EXPECT_FALSE(outputs->gate_allowed);
    EXPECT_FALSE(outputs->cancel_laser);
}

}  // namespace
}  // namespace sc::recording
