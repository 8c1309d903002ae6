// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "boards/stm32h743/registers/counter.hpp"
#include "boards/stm32h743/registers/gpio.hpp"
#include "tests/stm32h743/model/slow_lines.hpp"
#include "tests/stm32h743/register_table.hpp"

namespace sc::stm32h743 {
namespace {

TEST(SlowLinesRegisters, DriverAndModelHaveWhatTheTableHas) {
    const test::Table table = test::read_table("io");
    const Address g = gpio::base(gpio::Port::g);
    const std::map<std::string, std::uint32_t> driver{
        {"GPIOD_MODER", gpio::base(gpio::Port::d) + gpio::kModer},
        {"GPIOF_IDR", gpio::base(gpio::Port::f) + gpio::kIdr},
        {"GPIOG_MODER", g + gpio::kModer},
        {"GPIOG_OTYPER", g + gpio::kOtyper},
        {"GPIOG_PUPDR", g + gpio::kPupdr},
        {"GPIOG_IDR", g + gpio::kIdr},
        {"GPIOG_BSRR", g + gpio::kBsrr},
        {"RCC_AHB4ENR", gpio::kAhb4enr},
        {"RCC_APB1LENR", tim5::kApb1lenr},
        {"TIM5_CR1", tim5::kCr1},
        {"TIM5_EGR", tim5::kEgr},
        {"TIM5_CNT", tim5::kCnt},
        {"TIM5_PSC", tim5::kPsc},
        {"TIM5_ARR", tim5::kArr},
    };
    EXPECT_EQ(driver, table.address);
    const std::map<std::string, std::uint32_t> bits{
        {"RCC_AHB4ENR.GPIODEN", gpio::clock(gpio::Port::d)},
        {"RCC_AHB4ENR.GPIOFEN", gpio::clock(gpio::Port::f)},
        {"RCC_AHB4ENR.GPIOGEN", gpio::clock(gpio::Port::g)},
        {"RCC_APB1LENR.TIM5EN", tim5::kClock},
        {"TIM5_CR1.CEN", tim5::kCounterEnable},
        {"TIM5_EGR.UG", tim5::kGenerateUpdate},
    };
    EXPECT_EQ(bits, table.mask);
    EXPECT_EQ(model::SlowPort::kBase + 6 * model::SlowPort::kStep, table.address.at("GPIOG_MODER"));
    EXPECT_EQ(model::Counter::kBase, table.address.at("TIM5_CR1"));
}

}  // namespace
}  // namespace sc::stm32h743
