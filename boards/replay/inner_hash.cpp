// SPDX-License-Identifier: Apache-2.0
#include "boards/replay/inner_hash.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <span>

#include "shared/wire/bytes.hpp"

namespace sc::replay {
namespace {

void add_numbers(Sha256& hash, std::span<const double> numbers) {
    for (const double number : numbers) {
        std::array<std::uint8_t, sizeof(double)> bytes{};
        ByteWriter writer(bytes);
        writer.put(number);
        hash.update(bytes);
    }
}
void add_numbers(Sha256& hash, std::initializer_list<double> numbers) {
    add_numbers(hash, std::span(numbers.begin(), numbers.size()));
}

/// First number that is not in the hash. Fewer than there were: another path.
std::uint32_t first_new(std::uint32_t known, std::uint32_t first, std::uint32_t end) {
    return std::max(known <= end ? known : 0, first);
}

}  // namespace

void InnerHash::add_pieces(const trajectory::Ring<motion::Piece>& pieces, std::uint32_t& known) {
    for (std::uint32_t n = first_new(known, pieces.first(), pieces.end()); n < pieces.end(); ++n) {
        const motion::Piece& p = pieces[n];
        add_numbers(hash_, {p.start, p.duration});
        for (const trajectory::Quintic& axis : p.axis) {
            add_numbers(hash_, axis);
        }
        add_numbers(hash_, p.distance);
    }
    known = pieces.end();
}

void InnerHash::add(const Controller& controller) {
    const motion::PathMotion& path = controller.runner().motion();
    add_numbers(hash_, {controller.runner().pulse_speed(), path.rate()});
    add_pieces(path.planner().pieces(), planned_);
    add_pieces(path.made(), made_);
}

std::string InnerHash::hexadecimal() const {
    const auto digits = to_hex(hash_.digest());
    return {digits.begin(), digits.end()};
}

}  // namespace sc::replay
