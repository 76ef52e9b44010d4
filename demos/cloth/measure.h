// The cloth of one moment, asked by several methods side by side: the paper's, and those that never miss.
#ifndef QC_DEMOS_CLOTH_MEASURE_H
#define QC_DEMOS_CLOTH_MEASURE_H

#include "quickcullide/quickcullide.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

/// Who is asked, in the order of the table.
enum qcClothQuestion
{
    qc_clothCullide,
    qc_clothQuick,
    qc_clothQuickSorted,
    qc_clothQuickSortedBack,
    qc_clothSweep,
    qc_clothAuto,
    qc_clothLayers,
    qc_clothQuestionCount
};

struct qcClothQuestionDef
{
    const char* label;  ///< in the table
    const char* column; ///< begins the names of its columns in the CSV
    qcMethod method;
    bool backToFront, secondPassFromBack;
    bool neverMisses;
};

extern const std::array<qcClothQuestionDef, qc_clothQuestionCount> qcClothQuestions;

/// What one of them said of one moment.
struct qcClothAnswer
{
    uint32_t pcs = 0;
    double ms = 0;
    uint32_t resolution = 0; ///< pixels on a side; 0 without sampling
    bool byDevice = false;   ///< the device had a share
    /// Penetrating pairs that it found, all of them real, and pairs that one of the others found and it did not.
    size_t found = 0, missed = 0;
};

using qcClothAnswers = std::array<qcClothAnswer, qc_clothQuestionCount>;

/// Each function returns false with a message when a call failed.
class qcClothMeasure
{
  public:
    /// `request`: views, resolution and rounds of the sampled methods, threads of all.
    qcClothMeasure(qcDevice* device, const qcDetectDef& request);
    ~qcClothMeasure();
    qcClothMeasure(const qcClothMeasure&) = delete;
    qcClothMeasure& operator=(const qcClothMeasure&) = delete;

    /// Takes a first cloth, and has the device compile and the planner calibrate: no cost of a frame.
    bool Begin(const std::vector<float>& positions, const std::vector<uint32_t>& indices);
    /// Takes over the cloth of this moment.
    bool Update(const std::vector<float>& positions);
    /// All of the answer but what it missed.
    bool Ask(qcClothQuestion question, qcClothAnswer* answer);
    /// What each missed of what any found; all have been asked since the last update.
    void Judge(qcClothAnswers* answers) const;

    /// A flag a triangle: in the PCS of the last answer.
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

    /// One scene each: none profits from what another has just computed.
    struct Asked
    {
        qcScene* scene = nullptr;
        qcBodyId cloth{};
        Pairs pairs; ///< sorted
    };

    bool Check(qcStatus status);

    qcDevice* m_device;
    qcDetectDef m_request;
    std::array<Asked, qc_clothQuestionCount> m_asked;
    std::vector<uint8_t> m_marked;
    std::string m_message;
};

#endif
