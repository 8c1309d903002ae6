// SPDX-License-Identifier: Apache-2.0
#include "host/formats/station_log.hpp"

#include "host/formats/database.hpp"

namespace sc::host {

void log_stations(const std::filesystem::path& database, const std::string& time, const std::string& calibration,
                  const std::vector<StationFigure>& figures) {
    Database file(database, DatabaseAccess::read_write_create);
    Transaction transaction(file);
    Statement insert = file.prepare(
        "INSERT INTO measurements (time, kind, subject, quantity, value, sigma, unit, calibration) "
        "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
    for (const StationFigure& figure : figures) {
        insert.bind(1, std::string_view(time))
            .bind(2, std::string_view(figure.unit.empty() ? "station_refused" : "station"))
            .bind(3, std::string_view(figure.station))
            .bind(4, std::string_view(figure.quantity))
            .bind(5, figure.value)
            .bind(6, figure.sigma)
            .bind(7, std::string_view(figure.unit))
            .bind(8, std::string_view(calibration));
        insert.step();
        insert.reset();
    }
    transaction.commit();
}

}  // namespace sc::host
