// SPDX-License-Identifier: Apache-2.0
#include "host/formats/toml_reader.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "host/formats/error.hpp"
#include "host/formats/text.hpp"

namespace sc::host {

namespace {

std::string value_text(const toml::node& node) {
    if (const auto* text = node.as_string()) {
        return shortened(text->get());
    }
    if (const auto* number = node.as_floating_point()) {
        std::ostringstream out;
        out << number->get();
        return out.str();
    }
    if (const auto* number = node.as_integer()) {
        return std::to_string(number->get());
    }
    if (const auto* truth = node.as_boolean()) {
        return truth->get() ? "true" : "false";
    }
    return node.is_table() ? "a table" : (node.is_array() ? "a list" : "a date or time");
}

int line_at(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

}  // namespace

TomlReader::TomlReader(const std::filesystem::path& file, const toml::table& table, std::string name)
    : file_(&file), table_(&table), name_(std::move(name)) {}

bool TomlReader::has(std::string_view key) const { return table_->contains(key); }

int TomlReader::line() const { return name_.empty() ? 0 : line_at(*table_); }

int TomlReader::line_of(std::string_view key) const {
    const toml::node* node = table_->get(key);
    return node == nullptr ? line() : line_at(*node);
}

std::string TomlReader::path_of(std::string_view key) const {
    return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

void TomlReader::fail(std::string_view key, std::string_view problem, std::string value,
                      std::string_view action) const {
    throw InputError({.file = file_->string(),
                      .line = line_of(key),
                      .problem = path_of(key) + " " + std::string(problem),
                      .value = std::move(value),
                      .action = std::string(action)});
}

const toml::node& TomlReader::get(std::string_view key) {
    known_.emplace(key);
    const toml::node* node = table_->get(key);
    if (node == nullptr) {
        throw InputError({.file = file_->string(),
                          .line = line(),
                          .problem = "key is missing",
                          .value = path_of(key),
                          .action = "add it; docs/formats.md lists the keys"});
    }
    return *node;
}

void TomlReader::finish() const {
    for (const auto& [key, node] : *table_) {
        if (!known_.contains(key.str())) {
            throw InputError({.file = file_->string(),
                              .line = line_at(node),
                              .problem = "unknown key",
                              .value = shortened(path_of(key.str())),
                              .action = "check its spelling, or remove it; docs/formats.md lists the keys"});
        }
    }
}

std::string TomlReader::text(std::string_view key) {
    const toml::node& node = get(key);
    if (const auto* value = node.as_string()) {
        return value->get();
    }
    fail(key, "is not a text", value_text(node), "put it in quotes");
}

std::string TomlReader::text_or(std::string_view key, std::string_view otherwise) {
    return has(key) ? text(key) : std::string(otherwise);
}

std::size_t TomlReader::choice(std::string_view key, const std::vector<std::string_view>& words) {
    const std::string word = text(key);
    const auto at = std::ranges::find(words, word);
    if (at == words.end()) {
        fail(key, "has an unknown value", shortened(word), "use one of " + joined(words, ", "));
    }
    return static_cast<std::size_t>(at - words.begin());
}

double TomlReader::as_number(std::string_view key, const toml::node& node) const {
    double value = 0.0;
    if (const auto* real = node.as_floating_point()) {
        value = real->get();
    } else if (const auto* whole = node.as_integer()) {
        value = static_cast<double>(whole->get());
    } else {
        fail(key, "is not a number", value_text(node), "give a number with a decimal point, without quotes");
    }
    if (!std::isfinite(value)) {
        fail(key, "is not a finite number", value_text(node), "give a finite number");
    }
    return value;
}

double TomlReader::number(std::string_view key) { return as_number(key, get(key)); }

double TomlReader::number(std::string_view key, Limits limits) {
    const double value = number(key);
    if (value < limits.least || value > limits.most) {
        fail(key, "is out of range", decimal(value),
             "give a value from " + decimal(limits.least) + " to " + decimal(limits.most));
    }
    return value;
}

double TomlReader::number_or(std::string_view key, double otherwise, Limits limits) {
    return has(key) ? number(key, limits) : otherwise;
}

std::int64_t TomlReader::integer(std::string_view key, std::int64_t least, std::int64_t most) {
    const toml::node& node = get(key);
    const auto* value = node.as_integer();
    if (value == nullptr) {
        fail(key, "is not a whole number", value_text(node), "give a whole number");
    }
    if (value->get() < least || value->get() > most) {
        fail(key, "is out of range", std::to_string(value->get()),
             "give a value from " + std::to_string(least) + " to " + std::to_string(most));
    }
    return value->get();
}

std::int64_t TomlReader::integer_or(std::string_view key, std::int64_t otherwise, std::int64_t least,
                                    std::int64_t most) {
    return has(key) ? integer(key, least, most) : otherwise;
}

const toml::array& TomlReader::array(std::string_view key) {
    const toml::node& node = get(key);
    if (const auto* list = node.as_array()) {
        return *list;
    }
    fail(key, "is not a list", value_text(node), "give a list in square brackets");
}

std::vector<double> TomlReader::any_numbers(std::string_view key) {
    std::vector<double> out;
    for (const toml::node& node : array(key)) {
        out.push_back(as_number(key, node));
    }
    return out;
}

std::vector<double> TomlReader::numbers(std::string_view key, std::size_t count) {
    std::vector<double> out = any_numbers(key);
    if (out.size() != count) {
        fail(key, "has the wrong number of values", std::to_string(out.size()),
             "give " + std::to_string(count) + " numbers");
    }
    return out;
}

std::vector<std::string> TomlReader::texts(std::string_view key) {
    std::vector<std::string> out;
    for (const toml::node& node : array(key)) {
        if (const auto* value = node.as_string()) {
            out.push_back(value->get());
        } else {
            fail(key, "holds what is not a text", value_text(node), "put each entry in quotes");
        }
    }
    return out;
}

std::vector<std::int64_t> TomlReader::integers(std::string_view key) {
    std::vector<std::int64_t> out;
    for (const toml::node& node : array(key)) {
        if (const auto* value = node.as_integer()) {
            out.push_back(value->get());
        } else {
            fail(key, "holds what is not a whole number", value_text(node), "give whole numbers");
        }
    }
    return out;
}

std::vector<std::vector<double>> TomlReader::matrix(std::string_view key, std::size_t rows, std::size_t columns) {
    const std::string shape = std::to_string(rows) + " rows of " + std::to_string(columns) + " numbers";
    std::vector<std::vector<double>> out;
    for (const toml::node& node : array(key)) {
        const auto* row = node.as_array();
        if (row == nullptr || row->size() != columns) {
            fail(key, "has a row of the wrong shape", value_text(node), "give " + shape);
        }
        std::vector<double> values;
        for (const toml::node& entry : *row) {
            values.push_back(as_number(key, entry));
        }
        out.push_back(std::move(values));
    }
    if (out.size() != rows) {
        fail(key, "has the wrong number of rows", std::to_string(out.size()), "give " + shape);
    }
    return out;
}

Vec3 TomlReader::vector(std::string_view key) {
    const std::vector<double> v = numbers(key, 3);
    return {v[0], v[1], v[2]};
}

Vec3 TomlReader::vector_mm(std::string_view key) {
    const Vec3 v = vector(key);
    return {v.x / 1e3, v.y / 1e3, v.z / 1e3};
}

std::vector<TomlReader::Stop> TomlReader::stops_mm(std::string_view key) {
    std::vector<Stop> out;
    for (const toml::node& node : array(key)) {
        if (const auto* inner = node.as_table()) {
            TomlReader stop(*file_, *inner, path_of(key));
            const Vec3 via = stop.vector_mm("via");
            out.push_back({line_at(node), via, stop.vector_mm("to")});
            stop.finish();
            continue;
        }
        const auto* list = node.as_array();
        if (list == nullptr || list->size() != 3) {
            throw InputError({.file = file_->string(),
                              .line = line_at(node),
                              .problem = path_of(key) + " holds what is no place",
                              .value = value_text(node),
                              .action = "give [x, y, z], or { via = [x, y, z], to = [x, y, z] } for an arc"});
        }
        const auto mm = [&](std::size_t i) { return as_number(key, *list->get(i)) / 1e3; };
        out.push_back({line_at(node), std::nullopt, {mm(0), mm(1), mm(2)}});
    }
    return out;
}

TomlReader TomlReader::table(std::string_view key) {
    const toml::node& node = get(key);
    if (const auto* inner = node.as_table()) {
        return {*file_, *inner, path_of(key)};
    }
    fail(key, "is not a table", value_text(node), "write it as [" + path_of(key) + "]");
}

std::optional<TomlReader> TomlReader::table_if(std::string_view key) {
    return has(key) ? std::optional<TomlReader>(table(key)) : std::nullopt;
}

std::vector<TomlReader> TomlReader::tables(std::string_view key) {
    std::vector<TomlReader> out;
    if (!has(key)) {
        return out;
    }
    for (const toml::node& node : array(key)) {
        const auto* inner = node.as_table();
        if (inner == nullptr) {
            fail(key, "holds what is not a table", value_text(node), "write each as [[" + path_of(key) + "]]");
        }
        out.emplace_back(*file_, *inner, path_of(key));
    }
    return out;
}

}  // namespace sc::host
