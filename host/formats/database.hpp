// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace sc::host {

/// The disk or SQLite failed; `what()` names the file and what was being done.
class DatabaseError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// A prepared statement. Parameters and columns count from 1 and 0, as in SQLite. Lives no longer than its Database.
class Statement {
public:
    Statement(sqlite3* handle, std::string_view sql);
    Statement& bind(int index, std::int64_t value);
    Statement& bind(int index, double value);
    Statement& bind(int index, std::string_view value);
    /// True while there is a row.
    bool step();
    void reset();
    [[nodiscard]] std::int64_t integer(int column) const;
    [[nodiscard]] double real(int column) const;
    [[nodiscard]] std::string text(int column) const;

private:
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const noexcept;
    };
    sqlite3* handle_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

enum class DatabaseAccess : std::uint8_t { read_write_create, read_only };

/// The one owner of the project's SQLite file: opens it, checks that it is ours (application_id), brings its schema up
/// to date (schema.hpp) in one transaction, sets WAL and full sync. Throws InputError for a file that is missing (read
/// only), no database, of another program or of a newer schema; DatabaseError otherwise.
class Database {
public:
    Database(const std::filesystem::path& path, DatabaseAccess access);
    [[nodiscard]] Statement prepare(std::string_view sql);
    void run(std::string_view sql);
    [[nodiscard]] std::int64_t last_row() const;
    [[nodiscard]] int version();
    [[nodiscard]] const std::filesystem::path& file() const noexcept { return file_; }

private:
    struct Close {
        void operator()(sqlite3* handle) const noexcept;
    };
    void check_identity();
    void migrate();

    std::filesystem::path file_;
    std::unique_ptr<sqlite3, Close> handle_;
};

/// All or nothing: rolls back unless commit() was called.
class Transaction {
public:
    explicit Transaction(Database& database);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

private:
    Database* database_;
    bool open_ = true;
};

}  // namespace sc::host
