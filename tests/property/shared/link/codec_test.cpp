// SPDX-License-Identifier: Apache-2.0
#include "shared/link/codec.hpp"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "random_message.hpp"
#include "shared/link/serial.hpp"

namespace {

using namespace sc::link;  // NOLINT(google-build-using-namespace): the subject of this file
using Buffer = std::vector<std::uint8_t>;

template <class Message>
Buffer encoded(const Message& message, std::uint16_t counter) {
    Buffer out(kMessageCapacity);
    out.resize(encode_message(message, counter, out));
    return out;
}
template <class Message>
Buffer framed(const Message& message, std::uint16_t counter) {
    Buffer out(kSerialCapacity);
    out.resize(encode_serial(message, counter, out));
    return out;
}
/// Calls f for a random message of every type.
template <class F>
void each_type(Random& random, F&& f) {
    const auto one = [&](const auto& prototype) {
        f(random_message<std::remove_cvref_t<decltype(prototype)>>(random));
    };
    for_each_message(HostMessages{}, one);
    for_each_message(CellMessages{}, one);
}
struct Seen {
    std::uint8_t id;
    std::uint16_t counter;
    Buffer payload;
    bool operator==(const Seen&) const = default;
};
std::vector<Seen> receive(SerialReceiver& receiver, const Buffer& bytes) {
    std::vector<Seen> out;
    receiver.receive(bytes, [&out](const Envelope& e) {
        out.push_back({e.id, e.counter, Buffer(e.payload.begin(), e.payload.end())});
    });
    return out;
}
void flip(Buffer& bytes, std::size_t bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
}

TEST(CodecProperty, AnyMessageComesBack) {
    Random random(1);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    for (int round = 0; round < 2000; ++round) {
        each_type(random, [&random](const auto& message) {
            using Message = std::remove_cvref_t<decltype(message)>;
            const auto counter = static_cast<std::uint16_t>(random());
            const Buffer bytes = encoded(message, counter);
            ASSERT_GE(bytes.size(), kMessageOverhead);
            const auto envelope = open_message(bytes);
            ASSERT_TRUE(envelope.has_value());
            EXPECT_EQ(envelope->id, Message::kId);
            EXPECT_EQ(envelope->counter, counter);
            Message back;
            ASSERT_TRUE(decode_payload(envelope->payload, back));
            ASSERT_EQ(values_of(back), values_of(message));
        });
    }
}

TEST(CodecProperty, EverySingleBitErrorInAMessageIsRejected) {
    Random random(2);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    each_type(random, [](const auto& message) {
        Buffer bytes = encoded(message, 0x55AA);
        for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
            flip(bytes, bit);
            ASSERT_FALSE(open_message(bytes).has_value()) << message.kName << " bit " << bit;
            flip(bytes, bit);
        }
    });
}

TEST(CodecProperty, EveryDoubleBitErrorInAShortMessageIsRejected) {
    Buffer bytes = encoded(Heartbeat{0x0123456789ABCDEF}, 7);
    for (std::size_t a = 0; a < bytes.size() * 8; ++a) {
        flip(bytes, a);
        for (std::size_t b = 0; b < a; ++b) {
            flip(bytes, b);
            ASSERT_FALSE(open_message(bytes).has_value()) << a << " and " << b;
            flip(bytes, b);
        }
        flip(bytes, a);
    }
}

TEST(SerialProperty, EverySingleBitErrorInAFrameIsRejectedAndTheNextFrameIsTaken) {
    Random random(3);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    const Buffer next = framed(Heartbeat{42}, 2);
    const std::vector<Seen> only_next{{Heartbeat::kId, 2, {42, 0, 0, 0, 0, 0, 0, 0}}};
    each_type(random, [&](const auto& message) {
        Buffer bytes = framed(message, 1);
        const std::size_t delimiter = bytes.size() - 1;
        for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
            flip(bytes, bit);
            SerialReceiver receiver;
            const std::vector<Seen> alone = receive(receiver, bytes);
            ASSERT_TRUE(alone.empty()) << message.kName << " bit " << bit;
            const std::vector<Seen> after = receive(receiver, next);
            ASSERT_EQ(after, bit / 8 == delimiter ? std::vector<Seen>{} : only_next) << message.kName << " bit " << bit;
            ASSERT_GE(receiver.frames_bad(), 1U);
            flip(bytes, bit);
        }
    });
}

TEST(SerialProperty, GarbageNeverYieldsAMessage) {
    Random random(4);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    SerialReceiver receiver;
    for (int round = 0; round < 2000; ++round) {
        Buffer bytes(random() % 1500);
        const std::uint64_t density = 2 + random() % 300;
        for (std::uint8_t& byte : bytes) {
            byte = static_cast<std::uint8_t>(random() % density == 0 ? 0 : random());
        }
        ASSERT_TRUE(receive(receiver, bytes).empty());
    }
    EXPECT_GT(receiver.frames_bad(), 1000U);
}

TEST(SerialProperty, CutsAndInsertionsNeverYieldAMessageThatWasNotSent) {
    Random random(5);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    std::uint16_t counter = 0;
    std::size_t received = 0;
    for (int round = 0; round < 300; ++round) {
        Buffer bytes;
        std::vector<Seen> sent;
        each_type(random, [&](const auto& message) {
            const Buffer plain = encoded(message, counter);
            sent.push_back({message.kId, counter, Buffer(plain.begin() + 3, plain.end() - 4)});
            const Buffer frame = framed(message, counter++);
            bytes.insert(bytes.end(), frame.begin(), frame.end());
        });
        for (int spoil = 0; spoil < 6; ++spoil) {
            const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(random() % bytes.size());
            if (random() % 2 == 0) {
                const auto left = static_cast<std::uint64_t>(bytes.end() - at);
                bytes.erase(at, at + static_cast<std::ptrdiff_t>(1 + random() % std::min<std::uint64_t>(left, 20)));
            } else {
                bytes.insert(at, 1 + random() % 20, static_cast<std::uint8_t>(random()));
            }
        }
        SerialReceiver receiver;
        std::size_t place = 0;
        for (const Seen& seen : receive(receiver, bytes)) {
            while (place < sent.size() && !(sent[place] == seen)) {
                ++place;
            }
            ASSERT_LT(place, sent.size()) << "a message that was not sent, or out of order";
            ++place;
            ++received;
        }
    }
    EXPECT_GT(received, 1500U) << "most messages of 3900 must survive";
}

TEST(CodecProperty, DecodersTakeAnyPayloadOrRefuseIt) {
    Random random(6);  // NOLINT(cert-msc32-c,cert-msc51-cpp): a fixed seed repeats
    int handled = 0;
    for (int round = 0; round < 100'000; ++round) {
        // Exact-size storage, so that a sanitizer sees any read outside.
        Buffer payload(random() % (kPayloadCapacity + 1));
        for (std::uint8_t& byte : payload) {
            byte = static_cast<std::uint8_t>(random());
        }
        const Envelope envelope{static_cast<std::uint8_t>(random() % 80), 0, payload};
        const auto again = [&](const auto& message) {
            ++handled;
            Buffer out(kMessageCapacity);
            const std::size_t size = encode_message(message, 0, out);
            ASSERT_EQ(Buffer(out.begin() + 3, out.begin() + static_cast<std::ptrdiff_t>(size) - 4), payload);
        };
        static_cast<void>(dispatch(HostMessages{}, envelope, again));
        static_cast<void>(dispatch(CellMessages{}, envelope, again));
    }
    EXPECT_GT(handled, 20);
}

}  // namespace
