// SPDX-License-Identifier: Apache-2.0
#include "host/formats/pulse_trace.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

using Json = nlohmann::json;

/// A header lists some dozens of errors; anything larger is not one of ours.
constexpr std::uint32_t kHeaderLimit = 4U << 20U;
constexpr std::uint16_t kGalvoFramesPerTick = 100;

/// Reads a binary file front to back and says at which byte it was cut.
class TraceFile {
public:
    explicit TraceFile(const std::filesystem::path& path) : path_(path) {
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error)) {
            throw InputError(
                {.file = path.string(), .problem = "there is no such file", .action = "check the path of the trace"});
        }
        in_.open(path, std::ios::binary);
        if (!in_.is_open()) {
            throw InputError(
                {.file = path.string(), .problem = "cannot be read", .action = "check the file's permissions"});
        }
    }

    /// Fills `out`. False at the end of the file exactly; throws if the file ends within `out`.
    bool read(std::span<std::uint8_t> out, std::string_view what) {
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes of a file.
        in_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
        const auto got = static_cast<std::size_t>(in_.gcount());
        if (got != 0 && got < out.size()) {
            fail_cut(what);
        }
        offset_ += got;
        return got == out.size();
    }
    void need(std::span<std::uint8_t> out, std::string_view what) {
        if (!out.empty() && !read(out, what)) {
            fail_cut(what);
        }
    }
    [[noreturn]] void fail(std::string problem, std::string value, std::string action) const {
        throw InputError({.file = path_.string(),
                          .problem = std::move(problem),
                          .value = std::move(value),
                          .action = std::move(action)});
    }
    [[nodiscard]] std::uint64_t offset() const noexcept { return offset_; }

private:
    [[noreturn]] void fail_cut(std::string_view what) const {
        fail("ends within its " + std::string(what), "byte offset " + std::to_string(offset_),
             "the writer was stopped: run the job again, or use the records before that offset");
    }

    std::filesystem::path path_;
    std::ifstream in_;
    std::uint64_t offset_ = 0;
};

Vec3 vector_of(const Json& json) {
    return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

TraceHeader header_of(std::string text) {
    const Json json = Json::parse(text);
    TraceHeader header;
    if (json.contains("axis")) {
        header.axis.point.v = vector_of(json.at("axis").at("point_m"));
        const Vec3 direction = vector_of(json.at("axis").at("direction"));
        const double length = norm(direction);
        if (!(length > 0.5 && length < 2.0)) {
            throw Json::other_error::create(0, "the axis has no unit direction", &json);
        }
        header.axis.direction.v = (1.0 / length) * direction;
    }
    for (const Json& error : json.value("errors", Json::array())) {
        const Json& by = error.contains("compensated_by") ? error.at("compensated_by") : Json("");
        header.errors.push_back({.name = error.at("name").get<std::string>(),
                                 .value = error.at("value").get<double>(),
                                 .unit = error.at("unit").get<std::string>(),
                                 .compensated_by = by.is_null() ? std::string() : by.get<std::string>()});
    }
    header.machine = json.contains("machine") ? json.at("machine").dump() : std::string();
    header.json = std::move(text);
    return header;
}

TraceHeader read_header(TraceFile& file, const std::array<char, 8>& magic) {
    std::array<std::uint8_t, 8> found{};
    file.need(found, "magic");
    for (std::size_t i = 0; i < found.size(); ++i) {
        if (found[i] != static_cast<std::uint8_t>(magic[i])) {
            const std::string text(found.begin(), found.end());
            file.fail("is another kind of file, its magic is", shortened(text),
                      "give a file that starts with " + std::string(magic.begin(), magic.end()));
        }
    }
    std::array<std::uint8_t, 4> size_bytes{};
    file.need(size_bytes, "header's length");
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < size_bytes.size(); ++i) {
        size |= std::uint32_t{size_bytes[i]} << (8U * i);
    }
    if (size > kHeaderLimit) {
        file.fail("has a header of impossible length", std::to_string(size) + " bytes", "run the job again");
    }
    std::vector<std::uint8_t> bytes(size);
    file.need(bytes, "header");
    try {
        return header_of(std::string(bytes.begin(), bytes.end()));
    } catch (const Json::exception& error) {
        file.fail("has a header that cannot be understood", shortened(error.what()), "run the job again");
    }
}

}  // namespace

TraceHeader for_each_pulse(const std::filesystem::path& path,
                           const std::function<void(const trace::PulseRecord&)>& handle) {
    TraceFile file(path);
    TraceHeader header = read_header(file, trace::kPulseMagic);
    for (std::array<std::uint8_t, trace::kPulseRecordSize> bytes{}; file.read(bytes, "pulse record");) {
        handle(trace::unpack_pulse(bytes));
    }
    return header;
}

PulseTrace read_pulse_trace(const std::filesystem::path& path) {
    PulseTrace out{.file = path, .header = {}, .pulses = {}};
    out.header = for_each_pulse(path, [&out](const trace::PulseRecord& pulse) { out.pulses.push_back(pulse); });
    return out;
}

TraceHeader read_sample_header(const std::filesystem::path& path) {
    TraceFile file(path);
    return read_header(file, trace::kSampleMagic);
}

TraceHeader for_each_sample(const std::filesystem::path& path, const SampleHandler& handle) {
    TraceFile file(path);
    TraceHeader header = read_header(file, trace::kSampleMagic);
    std::vector<trace::GalvoSample> galvo;
    for (std::array<std::uint8_t, trace::kSampleRecordSize> bytes{}; file.read(bytes, "sample record");) {
        const trace::SampleRecord record = trace::unpack_sample(bytes);
        if (record.galvo_frames != 0 && record.galvo_frames != kGalvoFramesPerTick) {
            file.fail("claims an impossible number of galvo frames before byte offset " + std::to_string(file.offset()),
                      std::to_string(record.galvo_frames), "run the job again");
        }
        galvo.clear();
        for (std::uint16_t i = 0; i < record.galvo_frames; ++i) {
            std::array<std::uint8_t, trace::kGalvoSampleSize> frame{};
            file.need(frame, "galvo frames");
            galvo.push_back(trace::unpack_galvo(frame));
        }
        handle(record, galvo);
    }
    return header;
}

}  // namespace sc::host
