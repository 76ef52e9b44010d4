// The cloth of one moment, asked by other methods than the one that simulates it.
#ifndef QC_DEMOS_CLOTH_MEASURE_H
#define QC_DEMOS_CLOTH_MEASURE_H

#include "quickcullide/quickcullide.h"

#include <string>
#include <vector>

/// What one image method said of one moment.
struct qcClothAnswer
{
    uint32_t pcs = 0;
    size_t pairs = 0; ///< penetrating pairs it found; all of them are real
    double ms = 0;
    uint32_t resolution = 0;     ///< pixels on a side, as used
    std::vector<uint8_t> marked; ///< a flag a triangle: in the PCS
};

class qcClothMeasure
{
  public:
    /// `request`: views, resolution, rounds and threads of the image methods.
    qcClothMeasure(qcDevice* device, const qcDetectDef& request);
    ~qcClothMeasure();
    qcClothMeasure(const qcClothMeasure&) = delete;
    qcClothMeasure& operator=(const qcClothMeasure&) = delete;

    /// Takes over the cloth of this moment. Each function returns false with a message when a call failed.
    bool Update(const std::vector<float>& positions, const std::vector<uint32_t>& indices);
    /// Penetrating pairs, exactly.
    bool CountPenetrating(size_t* pairs);
    bool Ask(qcMethod method, qcClothAnswer* answer);

    const std::string& Message() const
    {
        return m_message;
    }

  private:
    bool Check(qcStatus status);

    qcScene* m_scene = nullptr;
    qcBodyId m_cloth{};
    size_t m_triangleCount = 0;
    qcDetectDef m_request;
    std::string m_message;
};

#endif
