// SPDX-License-Identifier: Apache-2.0
// Writes a capture with every message of the schema, its fields at random and at their ends, and a few troubles: what
// no real job has. usage: scribecell-protocol-sample FILE.pcap serial|can|canfd
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>

#include "host/formats/capture_file.hpp"
#include "shared/link/can_port.hpp"
#include "shared/link/schema.hpp"
#include "shared/link/seal.hpp"
#include "shared/link/serial.hpp"

namespace {

using namespace sc;  // NOLINT(google-build-using-namespace): a test

/// Field values: in the first round all bits set, in the second none, then at random.
struct Filler {
    std::mt19937_64& random;
    int round;

    std::uint64_t bits() { return round == 0 ? ~0ULL : round == 1 ? 0ULL : random(); }
    template <class T>
    void one(T& value) {
        value = static_cast<T>(bits());
    }
    void one(double& value) {
        value = round == 0 ? -std::numeric_limits<double>::max() : std::bit_cast<double>(bits());
        value = std::isfinite(value) ? value : 1.0 / 3.0;
    }
    template <class T>
    void operator()(std::string_view /*name*/, T& value) {
        one(value);
    }
    template <class T, std::size_t N>
    void operator()(std::string_view /*name*/, std::array<T, N>& values) {
        for (T& value : values) {
            one(value);
        }
    }
    void operator()(std::string_view /*name*/, link::Bytes& bytes) {
        bytes.size = static_cast<std::uint8_t>(round == 0 ? bytes.data.size() : bits() % (bytes.data.size() + 1));
        for (std::size_t i = 0; i < bytes.size; ++i) {
            bytes.data.at(i) = static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : random());
        }
    }
};

/// Where messages go: each is encoded, framed for its carrier and written.
class Sink {
public:
    Sink(const std::string& file, bool can, bool fd)
        : can_(can),
          writer_(file, can ? host::CaptureKind::can : host::CaptureKind::serial),
          ports_{link::CanPort<4096>(link::kCanIdToHost, fd), link::CanPort<4096>(link::kCanIdToController, fd)} {}

    enum class Trouble : std::uint8_t { none, spoilt, cut, twice };

    template <class Message>
    void send(const Message& message, bool to_controller, std::uint16_t counter, std::uint8_t minor,
              Trouble trouble = Trouble::none) {
        std::array<std::uint8_t, link::kSerialCapacity> bytes{};
        const std::size_t size = encode(message, counter, bytes, minor);
        time_ns_ += 1'234'567;
        if (!can_) {
            serial(to_controller, std::span(bytes).first(size), trouble);
            return;
        }
        link::CanPort<4096>& port = ports_.at(to_controller ? 1 : 0);
        (void)port.push(std::span(bytes).first(size));
        link::LinkCanFrame frame;
        for (bool first = true; port.next(frame); first = false) {
            host::CapturedFrame out{frame.id, frame.fd, {frame.data.begin(), frame.data.begin() + frame.size}};
            if (first && trouble == Trouble::cut) {
                continue;
            }
            if (first && trouble == Trouble::spoilt) {
                out.data.at(3) = static_cast<std::uint8_t>(out.data.at(3) ^ 0x10U);
            }
            writer_.can(out, time_ns_);
            if (first && trouble == Trouble::twice) {
                writer_.can(out, time_ns_);
            }
            time_ns_ += 100'000;
        }
    }

private:
    /// Each third message of a host over a serial line is sealed.
    template <class Message>
    std::size_t encode(const Message& message, std::uint16_t counter, std::span<std::uint8_t> out, std::uint8_t minor) {
        if constexpr (link::kSealable<Message> && Message::kId < link::HelloReply::kId) {
            if (!can_ && counter % 3 == 0) {
                const std::size_t size =
                    link::encode_sealed(message, counter, crypto::CmacKey(crypto::Key{1, 2, 3}), out, minor);
                if (size > 0) {
                    return size;
                }
            }
        }
        return link::encode_serial(message, counter, out, minor);
    }
    void serial(bool to_controller, std::span<std::uint8_t> bytes, Trouble trouble) {
        if (trouble == Trouble::spoilt) {
            bytes[2] = bytes[2] == 0x5A ? 0x5B : 0x5A;
        }
        const std::size_t gone = trouble == Trouble::cut ? 3 : 1;
        for (int i = 0; i < (trouble == Trouble::twice ? 2 : 1); ++i) {
            writer_.serial(to_controller, bytes.first(bytes.size() - gone), time_ns_);
            writer_.serial(to_controller, bytes.last(1), time_ns_);
        }
    }

    bool can_;
    host::CaptureWriter writer_;
    std::array<link::CanPort<4096>, 2> ports_;
    std::int64_t time_ns_ = 1'000'000;
};

template <class List>
void send_all(List list, Sink& sink, std::mt19937_64& random, bool to_controller) {
    using Trouble = Sink::Trouble;
    std::uint16_t counter = 65'500;  // wraps
    for (int round = 0; round < 12; ++round) {
        link::for_each_message(list, [&]<class Message>(Message message) {
            Filler filler{random, round};
            Message::visit(filler, message);
            const std::uint8_t minor = round % 4 == 3 ? link::since<Message>() : link::kProtocolMinor;
            sink.send(message, to_controller, counter++, minor);
            counter = static_cast<std::uint16_t>(counter + (round == 5 && Message::kId % 16 == 6 ? 2 : 0));  // lost
        });
        // Messages that come late, and of each one a frame that is spoilt, cut and twice.
        link::for_each_message(list, [&]<class Message>(Message message) {
            if constexpr (link::largest_payload<Message>() >= 8) {
                if (round == 5) {
                    sink.send(message, to_controller, static_cast<std::uint16_t>(counter - 3), link::kProtocolMinor);
                } else if (round >= 6 && round < 9) {
                    sink.send(message, to_controller, counter++, link::kProtocolMinor,
                              std::array{Trouble::spoilt, Trouble::cut, Trouble::twice}.at(
                                  static_cast<std::size_t>(round - 6)));
                }
            }
        });
    }
}

}  // namespace

int main(int argc, char** argv) {
    const std::string carrier = argc == 3 ? argv[2] : "";
    if (carrier != "serial" && carrier != "can" && carrier != "canfd") {
        std::fprintf(stderr, "usage: scribecell-protocol-sample FILE.pcap serial|can|canfd\n");
        return 2;
    }
    std::mt19937_64 random(7);
    Sink sink(argv[1], carrier != "serial", carrier == "canfd");
    send_all(link::HostMessages{}, sink, random, true);
    send_all(link::CellMessages{}, sink, random, false);
    return 0;
}
