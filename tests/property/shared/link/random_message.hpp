// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <string_view>
#include <type_traits>
#include <vector>

#include "shared/link/schema.hpp"

namespace sc::link {

using Random = std::mt19937_64;

/// Numbers of every size and sign, the ends of their range among them. Doubles are finite, so that a 32-bit build may
/// pass them through x87 registers.
template <class T>
T random_number(Random& random) {
    if constexpr (std::is_same_v<T, double>) {
        return static_cast<double>(static_cast<std::int64_t>(random())) / static_cast<double>(1 + random() % 1'000'000);
    } else {
        const std::uint64_t bits = random() >> (random() % 64);
        return static_cast<T>(random() % 2 == 0 ? bits : ~bits);
    }
}

struct RandomFields {
    Random& random;
    template <class T>
    void operator()(std::string_view /*name*/, T& value) {
        value = random_number<T>(random);
    }
    template <class T, std::size_t N>
    void operator()(std::string_view /*name*/, std::array<T, N>& values) {
        for (T& value : values) {
            value = random_number<T>(random);
        }
    }
    void operator()(std::string_view /*name*/, Bytes& bytes) {
        bytes.size = static_cast<std::uint8_t>(random() % (bytes.data.size() + 1));
        for (std::size_t i = 0; i < bytes.size; ++i) {
            bytes.data.at(i) = static_cast<std::uint8_t>(random() % 3 == 0 ? 0 : random());
        }
    }
};

template <class Message>
Message random_message(Random& random) {
    Message message;
    RandomFields fields{random};
    Message::visit(fields, message);
    return message;
}

/// Every field of a message as plain numbers, to compare messages that have no operator ==.
struct FieldValues {
    std::vector<std::uint64_t> values;
    template <class T>
    void operator()(std::string_view /*name*/, const T& value) {
        add(value);
    }
    template <class T, std::size_t N>
    void operator()(std::string_view /*name*/, const std::array<T, N>& array) {
        for (const T& value : array) {
            add(value);
        }
    }
    void operator()(std::string_view /*name*/, const Bytes& bytes) {
        add(bytes.size);
        for (std::size_t i = 0; i < bytes.size; ++i) {
            add(bytes.data.at(i));
        }
    }

private:
    template <class T>
    void add(T value) {
        if constexpr (std::is_same_v<T, double>) {
            values.push_back(std::bit_cast<std::uint64_t>(value));
        } else {
            values.push_back(static_cast<std::uint64_t>(value));
        }
    }
};

template <class Message>
std::vector<std::uint64_t> values_of(const Message& message) {
    FieldValues fields;
    Message::visit(fields, message);
    return fields.values;
}

}  // namespace sc::link
