// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>

/// Physical quantities as types: a speed cannot be passed where a length is meant, and no factor of a thousand can be
/// forgotten. The value is held in SI units (angles in radians). Costs nothing at run time: one double each.
///
/// Public interfaces and configuration take quantities; raw numbers appear only inside a formula or at the edge to a
/// wire, a register or a file, where the name carries the unit as a suffix (`_mm`, `_pm`, `_ns`).

namespace sc {

/// A quantity of dimension length^L · time^T · mass^M · angle^A. Values are in m, s, kg, rad.
template <int L, int T, int M = 0, int A = 0>
class Quantity {
public:
    constexpr Quantity() noexcept = default;
    /// From a value in SI units; explicit, because a bare number says nothing of its unit.
    [[nodiscard]] static constexpr Quantity from_si(double value) noexcept {
        Quantity quantity;
        quantity.value_ = value;
        return quantity;
    }
    [[nodiscard]] constexpr double si() const noexcept { return value_; }

    constexpr auto operator<=>(const Quantity&) const noexcept = default;
    constexpr Quantity operator-() const noexcept { return from_si(-value_); }
    constexpr Quantity& operator+=(Quantity other) noexcept {
        value_ += other.value_;
        return *this;
    }
    constexpr Quantity& operator-=(Quantity other) noexcept {
        value_ -= other.value_;
        return *this;
    }

private:
    double value_ = 0.0;
};

template <int L, int T, int M, int A>
constexpr Quantity<L, T, M, A> operator+(Quantity<L, T, M, A> a, Quantity<L, T, M, A> b) noexcept {
    return a += b;
}
template <int L, int T, int M, int A>
constexpr Quantity<L, T, M, A> operator-(Quantity<L, T, M, A> a, Quantity<L, T, M, A> b) noexcept {
    return a -= b;
}
template <int L, int T, int M, int A>
constexpr Quantity<L, T, M, A> operator*(Quantity<L, T, M, A> a, double b) noexcept {
    return Quantity<L, T, M, A>::from_si(a.si() * b);
}
template <int L, int T, int M, int A>
constexpr Quantity<L, T, M, A> operator*(double a, Quantity<L, T, M, A> b) noexcept {
    return b * a;
}
template <int L, int T, int M, int A>
constexpr Quantity<L, T, M, A> operator/(Quantity<L, T, M, A> a, double b) noexcept {
    return Quantity<L, T, M, A>::from_si(a.si() / b);
}
template <int L1, int T1, int M1, int A1, int L2, int T2, int M2, int A2>
constexpr Quantity<L1 + L2, T1 + T2, M1 + M2, A1 + A2> operator*(Quantity<L1, T1, M1, A1> a,
                                                                 Quantity<L2, T2, M2, A2> b) noexcept {
    return Quantity<L1 + L2, T1 + T2, M1 + M2, A1 + A2>::from_si(a.si() * b.si());
}
/// Division; a ratio of equal dimensions is a plain double, which is also how a value is read in a chosen unit:
/// `length / 1_mm`.
template <int L1, int T1, int M1, int A1, int L2, int T2, int M2, int A2>
constexpr auto operator/(Quantity<L1, T1, M1, A1> a, Quantity<L2, T2, M2, A2> b) noexcept {
    if constexpr (L1 == L2 && T1 == T2 && M1 == M2 && A1 == A2) {
        return a.si() / b.si();
    } else {
        return Quantity<L1 - L2, T1 - T2, M1 - M2, A1 - A2>::from_si(a.si() / b.si());
    }
}

using Length = Quantity<1, 0>;
using Duration = Quantity<0, 1>;
using Speed = Quantity<1, -1>;
using Acceleration = Quantity<1, -2>;
using Jerk = Quantity<1, -3>;
using Frequency = Quantity<0, -1>;
using Energy = Quantity<2, -2, 1>;
using Power = Quantity<2, -3, 1>;
using Angle = Quantity<0, 0, 0, 1>;
using AngularSpeed = Quantity<0, -1, 0, 1>;

inline constexpr double kPi = 3.14159265358979323846;

namespace literals {
// NOLINTBEGIN(google-runtime-int): the type of a literal operator is fixed by the language.
constexpr Length operator""_m(long double v) noexcept { return Length::from_si(static_cast<double>(v)); }
constexpr Length operator""_mm(long double v) noexcept { return Length::from_si(static_cast<double>(v) * 1e-3); }
constexpr Length operator""_mm(unsigned long long v) noexcept { return Length::from_si(static_cast<double>(v) * 1e-3); }
constexpr Length operator""_um(long double v) noexcept { return Length::from_si(static_cast<double>(v) * 1e-6); }
constexpr Length operator""_um(unsigned long long v) noexcept { return Length::from_si(static_cast<double>(v) * 1e-6); }
constexpr Duration operator""_s(long double v) noexcept { return Duration::from_si(static_cast<double>(v)); }
constexpr Duration operator""_ms(long double v) noexcept { return Duration::from_si(static_cast<double>(v) * 1e-3); }
constexpr Duration operator""_ms(unsigned long long v) noexcept {
    return Duration::from_si(static_cast<double>(v) * 1e-3);
}
constexpr Duration operator""_us(long double v) noexcept { return Duration::from_si(static_cast<double>(v) * 1e-6); }
constexpr Duration operator""_us(unsigned long long v) noexcept {
    return Duration::from_si(static_cast<double>(v) * 1e-6);
}
constexpr Speed operator""_mm_s(long double v) noexcept { return Speed::from_si(static_cast<double>(v) * 1e-3); }
constexpr Speed operator""_mm_s(unsigned long long v) noexcept { return Speed::from_si(static_cast<double>(v) * 1e-3); }
constexpr Speed operator""_m_s(long double v) noexcept { return Speed::from_si(static_cast<double>(v)); }
constexpr Acceleration operator""_m_s2(long double v) noexcept { return Acceleration::from_si(static_cast<double>(v)); }
constexpr Jerk operator""_m_s3(long double v) noexcept { return Jerk::from_si(static_cast<double>(v)); }
constexpr Frequency operator""_kHz(long double v) noexcept { return Frequency::from_si(static_cast<double>(v) * 1e3); }
constexpr Frequency operator""_kHz(unsigned long long v) noexcept {
    return Frequency::from_si(static_cast<double>(v) * 1e3);
}
constexpr Energy operator""_uJ(long double v) noexcept { return Energy::from_si(static_cast<double>(v) * 1e-6); }
constexpr Power operator""_W(long double v) noexcept { return Power::from_si(static_cast<double>(v)); }
constexpr Angle operator""_deg(long double v) noexcept {
    return Angle::from_si(static_cast<double>(v) * (kPi / 180.0));
}
constexpr Angle operator""_deg(unsigned long long v) noexcept {
    return Angle::from_si(static_cast<double>(v) * (kPi / 180.0));
}
// NOLINTEND(google-runtime-int)
}  // namespace literals

}  // namespace sc
