// SPDX-License-Identifier: Apache-2.0
#include "host/pendant/hid_port.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include <hidapi/hidapi.h>

namespace sc::host::pendant {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLookEvery = std::chrono::milliseconds(250);
constexpr int kReadMs = 50;
constexpr std::size_t kMostWaiting = 256;  ///< reports; beyond, the oldest go

struct Closer {
    void operator()(hid_device* device) const { hid_close(device); }
};
using Handle = std::unique_ptr<hid_device, Closer>;

struct Stamped {
    PortEvent event;
    Clock::time_point at;
};

}  // namespace

/// hidapi keeps its last error in one place for all that open and look: `opening`.
struct HidPort::Shared {
    std::string wanted;
    std::mutex opening;

    mutable std::mutex lock;
    std::condition_variable changed;
    std::deque<Stamped> events;
    std::string path;  ///< of the device that is open; empty: none
    std::string problem;
    std::optional<Display> display;
    bool over = false;

    std::thread reader;
    std::thread writer;

    std::string find() {
        if (!wanted.empty()) {
            return wanted;
        }
        const std::lock_guard guard(opening);
        hid_device_info* const all = hid_enumerate(kVendor, kProduct);
        std::string found = all != nullptr && all->path != nullptr ? all->path : "";
        hid_free_enumeration(all);
        return found;
    }
    Handle open(const std::string& file) {
        const std::lock_guard guard(opening);
        return Handle(file.empty() ? nullptr : hid_open_path(file.c_str()));
    }
    void put(const PortEvent& event) {
        const std::lock_guard guard(lock);
        if (events.size() >= kMostWaiting && event.kind == PortEvent::Kind::report) {
            events.pop_front();
        }
        events.push_back({event, Clock::now()});
    }
    bool rest(std::chrono::milliseconds time) {
        std::unique_lock guard(lock);
        return !changed.wait_for(guard, time, [this] { return over; });
    }
    bool ending() {
        const std::lock_guard guard(lock);
        return over;
    }
    void set_path(const std::string& file) {
        const std::lock_guard guard(lock);
        path = file;
        changed.notify_all();
    }
    void read();
    void read_all(hid_device* device);
    void write();
};

void HidPort::Shared::read_all(hid_device* device) {
    while (!ending()) {
        PortEvent event;
        const int size = hid_read_timeout(device, event.bytes.data(), event.bytes.size(), kReadMs);
        if (size < 0) {
            return;
        }
        if (size > 0) {
            event.size = static_cast<std::size_t>(size);
            put(event);
        }
    }
}

void HidPort::Shared::read() {
    do {
        const std::string file = find();
        const Handle device = open(file);
        {
            const std::lock_guard guard(lock);
            problem = !file.empty() && !device ? file + " cannot be opened (docs/pendant.md: who may)" : "";
        }
        if (!device) {
            continue;
        }
        PortEvent event;
        event.kind = PortEvent::Kind::plugged;
        put(event);
        set_path(file);
        read_all(device.get());
        set_path({});
        event.kind = PortEvent::Kind::unplugged;
        put(event);
    } while (rest(kLookEvery));
}

void HidPort::Shared::write() {
    Handle device;
    std::string open_path;
    std::unique_lock guard(lock);
    while (!over) {
        changed.wait(guard, [this] { return over || (display && !path.empty()); });
        if (over) {
            break;
        }
        const auto reports = to_reports(*display);
        display.reset();
        const std::string file = path;
        guard.unlock();
        if (!device || open_path != file) {
            device = open(file);
            open_path = file;
        }
        for (const auto& report : reports) {
            if (!device || hid_send_feature_report(device.get(), report.data(), report.size()) < 0) {
                device.reset();
            }
        }
        guard.lock();
    }
}

HidPort::HidPort(std::string device) : shared_(std::make_unique<Shared>()) {
    shared_->wanted = std::move(device);
    hid_init();
    shared_->reader = std::thread([shared = shared_.get()] { shared->read(); });
    shared_->writer = std::thread([shared = shared_.get()] { shared->write(); });
}

HidPort::~HidPort() {
    {
        const std::lock_guard guard(shared_->lock);
        shared_->over = true;
        shared_->changed.notify_all();
    }
    shared_->reader.join();
    shared_->writer.join();
}

std::optional<PortEvent> HidPort::next(HostTime /*now*/) {
    const std::lock_guard guard(shared_->lock);
    if (shared_->events.empty()) {
        return std::nullopt;
    }
    Stamped first = shared_->events.front();
    shared_->events.pop_front();
    first.event.age = std::chrono::duration_cast<Nanoseconds>(Clock::now() - first.at);
    return first.event;
}

void HidPort::show(const Display& display) {
    const std::lock_guard guard(shared_->lock);
    shared_->display = display;
    shared_->changed.notify_all();
}

std::string HidPort::problem() const {
    const std::lock_guard guard(shared_->lock);
    return shared_->problem;
}

}  // namespace sc::host::pendant
