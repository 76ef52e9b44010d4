// One state of the cloth, queried by several methods side by side: the paper's, and those that never miss.
#ifndef QC_DEMOS_CLOTH_MEASURE_H
#define QC_DEMOS_CLOTH_MEASURE_H

#include "quickcullide/quickcullide.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

/// The queries, in the order of the table.
enum qcClothQuery
{
    qc_clothCullide,
    qc_clothQuick,
    qc_clothQuickSorted,
    qc_clothQuickSortedBack,
    qc_clothSweep,
    qc_clothAuto,
    qc_clothLayers,
    qc_clothQueryCount
};

struct qcClothQueryDef
{
    const char* label;  ///< in the table
    const char* column; ///< prefix of its columns in the CSV
    qcMethod method;
    bool backToFront, secondPassFromBack;
    bool neverMisses;
};

extern const std::array<qcClothQueryDef, qc_clothQueryCount> qcClothQueries;

/// The result of one query on one state of the cloth.
struct qcClothResult
{
    uint32_t pcs = 0;
    double ms = 0;
    uint32_t resolution = 0; ///< pixels on a side; 0 without sampling
    bool byDevice = false;   ///< part of it ran on the device
    /// Penetrating pairs that the query found, confirmed by the exact test, and pairs that only other queries found.
    size_t found = 0, missed = 0;
};

using qcClothResults = std::array<qcClothResult, qc_clothQueryCount>;

/// Each function returns false with a message when a call failed.
class qcClothMeasure
{
  public:
    /// `request`: views, resolution and rounds of the sampled methods, threads of all.
    qcClothMeasure(qcDevice* device, const qcDetectDef& request);
    ~qcClothMeasure();
    qcClothMeasure(const qcClothMeasure&) = delete;
    qcClothMeasure& operator=(const qcClothMeasure&) = delete;

    /// Takes a first cloth and runs the methods once: shaders are compiled and the planner is calibrated before the
    /// first frame.
    bool Begin(const std::vector<float>& positions, const std::vector<uint32_t>& indices);
    /// Takes the current state of the cloth.
    bool Update(const std::vector<float>& positions);
    /// Fills all of the result but `missed`.
    bool Run(qcClothQuery query, qcClothResult* result);
    /// Fills `missed`: the pairs that another query found and this one did not. Call it after all queries have run
    /// since the last update.
    void CountMissed(qcClothResults* results) const;

    /// A flag for each triangle: it is in the PCS of the last query.
    const std::vector<uint8_t>& Marked() const
    {
        return m_marked;
    }
    const std::string& Message() const
    {
        return m_message;
    }

  private:
    using Pairs = std::vector<std::pair<uint32_t, uint32_t>>;

    /// One scene for each query: no query reuses data of another.
    struct Queried
    {
        qcScene* scene = nullptr;
        qcBodyId cloth{};
        Pairs pairs; ///< sorted
    };

    bool Check(qcStatus status);

    qcDevice* m_device;
    qcDetectDef m_request;
    std::array<Queried, qc_clothQueryCount> m_queried;
    std::vector<uint8_t> m_marked;
    std::string m_message;
};

#endif
