// SPDX-License-Identifier: Apache-2.0
#include "host/formats/job_items.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/formats/byte_file.hpp"
#include "host/formats/error.hpp"
#include "host/formats/file.hpp"
#include "shared/path/block.hpp"
#include "shared/path/job_hash.hpp"
#include "shared/wire/bytes.hpp"

namespace sc::host {
namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'S', 'C', 'I', 'T', 'E', 'M', '0', '1'};
constexpr std::size_t kHead = kMagic.size() + 1 + 8 + 4;
constexpr std::size_t kBlockBytes = 1024;
constexpr std::size_t kBlockHead = 3;

[[noreturn]] void fail(const std::filesystem::path& path, std::string problem, std::string value, std::string action) {
    throw InputError(
        {.file = path.string(), .problem = std::move(problem), .value = std::move(value), .action = std::move(action)});
}

[[noreturn]] void fail_cut(const std::filesystem::path& path, std::size_t byte) {
    fail(path, "ends or breaks within a block, at byte", std::to_string(byte), "copy the file again");
}

template <std::size_t kSize>
void append(std::string& text, const std::array<std::uint8_t, kSize>& bytes, std::size_t count = kSize) {
    std::for_each_n(bytes.begin(), count, [&text](std::uint8_t byte) { text.push_back(static_cast<char>(byte)); });
}

}  // namespace

void write_job_items(const std::filesystem::path& path, std::span<const Item> items) {
    std::string text;
    std::array<std::uint8_t, kHead> head{};
    ByteWriter writer(head);
    writer.put_bytes(kMagic);
    writer.put(kBlockGrammarVersion);
    writer.put(job_hash(items));
    writer.put(static_cast<std::uint32_t>(items.size()));
    append(text, head);
    std::array<std::uint8_t, kBlockBytes> block{};
    while (!items.empty()) {
        const BlockSize size = encode_block(items, block);
        std::array<std::uint8_t, kBlockHead> block_head{};
        ByteWriter begin(block_head);
        begin.put(static_cast<std::uint8_t>(size.items));
        begin.put(static_cast<std::uint16_t>(size.bytes));
        append(text, block_head);
        append(text, block, size.bytes);
        items = items.subspan(size.items);
    }
    write_text_file(path, text);
}

std::vector<Item> read_job_items(const std::filesystem::path& path) {
    const ByteFile file(path);
    const std::string_view text = file.bytes();
    std::vector<std::uint8_t> bytes(text.size());
    std::ranges::transform(text, bytes.begin(), [](char c) { return std::bit_cast<std::uint8_t>(c); });
    ByteReader in(bytes);
    const std::span<const std::uint8_t> magic = in.get_bytes(kMagic.size());
    const auto version = in.get<std::uint8_t>();
    const auto hash = in.get<std::uint64_t>();
    const auto count = in.get<std::uint32_t>();
    if (!in.ok() || !std::ranges::equal(magic, kMagic)) {
        fail(path, "is not a file of a job's items", std::string(text.substr(0, kMagic.size())),
             "give the job.items that scribe has written into its folder");
    }
    if (version != kBlockGrammarVersion) {
        fail(path, "holds items of another version", std::to_string(version),
             "read it with the version of scribecell that wrote it; this one knows " +
                 std::to_string(kBlockGrammarVersion));
    }
    std::vector<Item> items;
    while (in.remaining() > 0) {
        const std::size_t at = bytes.size() - in.remaining();
        const auto block_items = in.get<std::uint8_t>();
        const auto block_bytes = in.get<std::uint16_t>();
        const std::span<const std::uint8_t> block = in.get_bytes(block_bytes);
        BlockReader reader(block, block_items);
        Item item;
        auto more = in.ok() ? reader.next(item) : std::unexpected(Refusal::malformed_block);
        for (; more && *more; more = reader.next(item)) {
            items.push_back(item);
        }
        if (!more) {
            fail_cut(path, at);
        }
    }
    if (items.size() != count || job_hash(items) != hash) {
        fail(path, "holds other items than it says", std::to_string(items.size()) + " of " + std::to_string(count),
             "copy the file again");
    }
    return items;
}

}  // namespace sc::host
