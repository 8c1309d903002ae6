// SPDX-License-Identifier: Apache-2.0
#include "host/bridge/ports.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include <fcntl.h>
#include <grp.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/bridge/unique_fd.hpp"

namespace sc::host {
namespace {

namespace fs = std::filesystem;

constexpr int kCanDevice = 280;       ///< ARPHRD_CAN
constexpr unsigned kInterfaceUp = 1;  ///< IFF_UP
constexpr unsigned long kFdMtu = 72;
constexpr std::uint32_t kQueueNeeded = 128;
constexpr unsigned kPendantVendor = 0x10CE;

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    std::string text;
    std::getline(in, text);
    return text;
}

unsigned long number_of(const fs::path& file) { return std::strtoul(text_of(file).c_str(), nullptr, 0); }

std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

/// What a person without the right to use a device does.
std::string how_to_get(const std::string& path, const char* usual_group) {
    struct stat info{};
    std::string group = usual_group;
    if (::stat(path.c_str(), &info) == 0) {
        if (const ::group* found = ::getgrgid(info.st_gid); found != nullptr && info.st_gid != 0) {
            group = found->gr_name;
        }
    }
    return "no right to read and write: sudo usermod -aG " + group + " $USER, then log in again";
}

class Finder {
public:
    explicit Finder(const PortSources& sources) : s_(sources) {}

    Ports all() {
        Ports ports;
        can(ports);
        serial(ports);
        hid(ports);
        gpio(ports);
        return ports;
    }

private:
    [[nodiscard]] bool may_use(const std::string& path) const {
        return s_.may_use ? s_.may_use(path) : ::access(path.c_str(), R_OK | W_OK) == 0;
    }

    void can(Ports& ports) const {
        if (!s_.kernel_has_can) {
            ports.missing.emplace_back("this kernel has no SocketCAN: modprobe can_raw, or start a kernel that has it");
        }
        const fs::path net = s_.root / "sys/class/net";
        for (const std::string& name : names_in(net)) {
            if (number_of(net / name / "type") != kCanDevice) {
                continue;
            }
            CanInterface one;
            one.name = name;
            one.up = (number_of(net / name / "flags") & kInterfaceUp) != 0;
            one.fd = number_of(net / name / "mtu") >= kFdMtu;
            one.details =
                s_.can_details(static_cast<unsigned>(number_of(net / name / "ifindex"))).value_or(CanDetails{});
            if (one.details.queue_length == 0) {
                one.details.queue_length = static_cast<std::uint32_t>(number_of(net / name / "tx_queue_len"));
            }
            judge(one);
            ports.can.push_back(std::move(one));
        }
    }
    static void judge(CanInterface& one) {
        const CanDetails& d = one.details;
        const std::string set = "sudo ip link set " + one.name;
        const bool real = d.kind == "can";
        if (!one.up) {
            one.missing.push_back("it is down: " + set +
                                  (real ? " up type can bitrate 1000000 restart-ms 100" : " up"));
        } else if (d.state == "bus-off") {
            one.missing.push_back("bus-off: mend wiring, termination or rate, then " + set + " type can restart");
        } else if (d.state == "error-passive" || d.state == "error-warning") {
            one.missing.push_back("many errors (" + d.state +
                                  "): check rate, termination and that somebody else is there");
        }
        if (real && one.up && d.restart_ms == 0) {
            one.missing.push_back("it stays off after a bus-off: " + set + " down; " + set +
                                  " up type can restart-ms 100");
        }
        if (d.queue_length > 0 && d.queue_length < kQueueNeeded) {
            one.missing.push_back("its queue of " + std::to_string(d.queue_length) + " frames is short: " + set +
                                  " txqueuelen " + std::to_string(kQueueNeeded));
        }
    }

    void serial(Ports& ports) const {
        std::map<std::string, std::string> by_id;
        const fs::path ids = s_.root / "dev/serial/by-id";
        for (const std::string& name : names_in(ids)) {
            std::error_code ignored;
            by_id[fs::read_symlink(ids / name, ignored).filename().string()] = (ids / name).string();
        }
        const fs::path tty = s_.root / "sys/class/tty";
        for (const std::string& name : names_in(tty)) {
            std::error_code ignored;
            const fs::path driver = tty / name / "device/driver";
            // A UART that was never found has type 0.
            const bool absent = fs::exists(tty / name / "type", ignored) && number_of(tty / name / "type") == 0;
            if (!fs::exists(driver, ignored) || absent) {
                continue;
            }
            SerialPortName one;
            one.device = (s_.root / "dev" / name).string();
            one.driver = fs::read_symlink(driver, ignored).filename().string();
            one.by_id = by_id[name];
            if (!may_use(one.device)) {
                one.missing.push_back(how_to_get(one.device, "dialout"));
            }
            ports.serial.push_back(std::move(one));
        }
    }

    void hid(Ports& ports) const {
        const fs::path raw = s_.root / "sys/class/hidraw";
        for (const std::string& name : names_in(raw)) {
            HidDevice one;
            one.device = (s_.root / "dev" / name).string();
            std::ifstream in(raw / name / "device/uevent");
            for (std::string line; std::getline(in, line);) {
                if (line.starts_with("HID_NAME=")) {
                    one.name = line.substr(9);
                } else if (line.starts_with("HID_ID=")) {
                    // bus:vendor:product, hexadecimal
                    std::istringstream id(line.substr(7));
                    char colon = 0;
                    unsigned bus = 0;
                    id >> std::hex >> bus >> colon >> one.vendor >> colon >> one.product;
                }
            }
            one.pendant = one.vendor == kPendantVendor && (one.product == 0xEB93 || one.product == 0xEB91);
            if (one.pendant && !may_use(one.device)) {
                one.missing.emplace_back(
                    "no right to read and write: a udev rule, KERNEL==\"hidraw*\", ATTRS{idVendor}==\"10ce\", "
                    "MODE=\"0660\", GROUP=\"plugdev\"");
            }
            ports.hid.push_back(std::move(one));
        }
    }

    void gpio(Ports& ports) const {
        for (const std::string& name : names_in(s_.root / "dev")) {
            if (!name.starts_with("gpiochip")) {
                continue;
            }
            GpioChip one;
            one.device = (s_.root / "dev" / name).string();
            if (!may_use(one.device)) {
                one.missing.push_back(how_to_get(one.device, "gpio"));
            }
            const UniqueFd file(::open(one.device.c_str(), O_RDONLY | O_CLOEXEC));
            gpiochip_info info{};
            if (file.valid() && ::ioctl(file.get(), GPIO_GET_CHIPINFO_IOCTL, &info) == 0) {
                one.label = static_cast<const char*>(info.label);
                one.lines = info.lines;
            }
            ports.gpio.push_back(std::move(one));
        }
    }

    PortSources s_;
};

}  // namespace

Ports find_ports(const PortSources& sources) { return Finder(sources).all(); }

Ports find_ports() {
    PortSources sources;
    const UniqueFd probe(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, 1));
    sources.kernel_has_can = probe.valid();
    return find_ports(sources);
}

}  // namespace sc::host
