// SPDX-License-Identifier: Apache-2.0
#include "host/formats/database.hpp"

#include <string>
#include <utility>

#include <sqlite3.h>

#include "host/formats/error.hpp"
#include "host/formats/schema.hpp"

namespace sc::host {

namespace {

/// How long a second process may hold the file before we give up.
constexpr int kBusyTimeoutMs = 5000;

[[noreturn]] void fail(sqlite3* handle, std::string_view doing) {
    const char* file = handle == nullptr ? nullptr : sqlite3_db_filename(handle, "main");
    throw DatabaseError(std::string(file == nullptr ? "database" : file) + ": " + std::string(doing) + ": " +
                        (handle == nullptr ? "out of memory" : sqlite3_errmsg(handle)));
}

void check(sqlite3* handle, int code, std::string_view doing) {
    if (code != SQLITE_OK) {
        fail(handle, doing);
    }
}

sqlite3* opened(const std::filesystem::path& path, DatabaseAccess access) {
    const bool read_only = access == DatabaseAccess::read_only;
    if (read_only && !std::filesystem::is_regular_file(path)) {
        throw InputError({.file = path.string(),
                          .problem = "there is no such journal",
                          .action = "check the path; a journal is made when a job starts"});
    }
    const int flags = read_only ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
    sqlite3* handle = nullptr;
    if (const int code = sqlite3_open_v2(path.c_str(), &handle, flags, nullptr); code != SQLITE_OK) {
        const std::string reason = sqlite3_errstr(code);
        sqlite3_close(handle);
        throw InputError({.file = path.string(),
                          .problem = "cannot be opened as a journal",
                          .value = reason,
                          .action = "check the folder and the permissions"});
    }
    return handle;
}

}  // namespace

void Statement::Finalize::operator()(sqlite3_stmt* statement) const noexcept { sqlite3_finalize(statement); }

Statement::Statement(sqlite3* handle, std::string_view sql) : handle_(handle) {
    sqlite3_stmt* statement = nullptr;
    check(handle, sqlite3_prepare_v2(handle, sql.data(), static_cast<int>(sql.size()), &statement, nullptr), sql);
    statement_.reset(statement);
}

Statement& Statement::bind(int index, std::int64_t value) {
    check(handle_, sqlite3_bind_int64(statement_.get(), index, value), "bind");
    return *this;
}

Statement& Statement::bind(int index, double value) {
    check(handle_, sqlite3_bind_double(statement_.get(), index, value), "bind");
    return *this;
}

Statement& Statement::bind(int index, std::string_view value) {
    const std::string text(value);
    // NOLINTNEXTLINE(performance-no-int-to-ptr): SQLite defines SQLITE_TRANSIENT, "copy it", as this cast.
    auto* const copy_it = reinterpret_cast<sqlite3_destructor_type>(-1);
    const int size = static_cast<int>(text.size());
    check(handle_, sqlite3_bind_text(statement_.get(), index, text.c_str(), size, copy_it), "bind");
    return *this;
}

bool Statement::step() {
    const int code = sqlite3_step(statement_.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) {
        fail(handle_, sqlite3_sql(statement_.get()));
    }
    return code == SQLITE_ROW;
}

void Statement::reset() { sqlite3_reset(statement_.get()); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }

std::string Statement::text(int column) const {
    const unsigned char* bytes = sqlite3_column_text(statement_.get(), column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): SQLite hands UTF-8 out as unsigned char.
    return bytes == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(bytes), size);
}

void Database::Close::operator()(sqlite3* handle) const noexcept { sqlite3_close_v2(handle); }

Database::Database(const std::filesystem::path& path, DatabaseAccess access)
    : file_(path), handle_(opened(path, access)) {
    sqlite3_busy_timeout(handle_.get(), kBusyTimeoutMs);
    check_identity();
    if (access == DatabaseAccess::read_write_create) {
        run("PRAGMA journal_mode = WAL");
        run("PRAGMA synchronous = FULL");
        run("PRAGMA foreign_keys = ON");
        migrate();
    }
}

Statement Database::prepare(std::string_view sql) { return {handle_.get(), sql}; }

void Database::run(std::string_view sql) {
    check(handle_.get(), sqlite3_exec(handle_.get(), std::string(sql).c_str(), nullptr, nullptr, nullptr), sql);
}

std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(handle_.get()); }

int Database::version() {
    Statement query = prepare("PRAGMA user_version");
    return query.step() ? static_cast<int>(query.integer(0)) : 0;
}

void Database::check_identity() {
    InputProblem problem{.file = file_.string(),
                         .problem = "is not a journal of this program",
                         .action = "name another file; this one is left as it is"};
    try {
        Statement identity = prepare(
            "SELECT (SELECT count(*) FROM sqlite_schema), application_id "
            "FROM pragma_application_id");
        const bool is_new = identity.step() && identity.integer(0) == 0 && identity.integer(1) == 0;
        if (is_new || identity.integer(1) == kApplicationId) {
            problem.problem.clear();
        }
    } catch (const DatabaseError&) {
        if (sqlite3_errcode(handle_.get()) != SQLITE_NOTADB) {
            throw;
        }
    }
    if (!problem.problem.empty()) {
        throw InputError(std::move(problem));
    }
    if (const int found = version(); found > static_cast<int>(schema_migrations().size())) {
        throw InputError({.file = file_.string(),
                          .problem = "is of a newer schema than this program knows",
                          .value = std::to_string(found),
                          .action = "use a newer scribecell"});
    }
}

void Database::migrate() {
    const auto migrations = schema_migrations();
    const auto from = static_cast<std::size_t>(version());
    if (from == migrations.size()) {
        return;
    }
    Transaction transaction(*this);
    // Another process may have migrated while this one waited for the lock.
    for (auto i = static_cast<std::size_t>(version()); i < migrations.size(); ++i) {
        run(migrations[i]);
    }
    run("PRAGMA application_id = " + std::to_string(kApplicationId));
    run("PRAGMA user_version = " + std::to_string(migrations.size()));
    transaction.commit();
}

Transaction::Transaction(Database& database) : database_(&database) { database_->run("BEGIN IMMEDIATE"); }

Transaction::~Transaction() {
    if (open_) {
        try {
            database_->run("ROLLBACK");
        } catch (const DatabaseError&) {
            open_ = false;  // SQLite has rolled back by itself
        }
    }
}

void Transaction::commit() {
    database_->run("COMMIT");
    open_ = false;
}

}  // namespace sc::host
