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

void InnerHash::add(const Controller& controller) {
    const motion::Planner& planner = controller.runner().planner();
    const motion::ElementRing& elements = planner.elements();
    const motion::TimeLaw& law = planner.law();
    add_numbers(hash_, {controller.runner().pulse_speed(), law.end_time()});
    for (std::uint32_t n = first_new(elements_, elements.first(), elements.end()); n < elements.end(); ++n) {
        const motion::Element& e = elements.at(n);
        add_numbers(hash_, {e.start, e.length, e.distance, e.true_length, e.cap});
        add_numbers(hash_, e.origin);
        add_numbers(hash_, e.d1);
        add_numbers(hash_, e.bend);
    }
    for (std::uint32_t n = first_new(pieces_, law.first(), law.published()); n < law.published(); ++n) {
        const motion::Piece& p = law.at(n);
        add_numbers(hash_, {p.t0, p.duration, p.tau0, p.v0, p.a0, p.j});
    }
    elements_ = elements.end();
    pieces_ = law.published();
}

std::string InnerHash::hexadecimal() const {
    const auto digits = to_hex(hash_.digest());
    return {digits.begin(), digits.end()};
}

}  // namespace sc::replay
