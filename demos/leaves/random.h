// Random numbers that depend on the seed alone, whatever the C++ library.
#ifndef QC_DEMOS_LEAVES_RANDOM_H
#define QC_DEMOS_LEAVES_RANDOM_H

#include <LinearMath/btScalar.h>

#include <random>

class qcRandom
{
  public:
    explicit qcRandom(uint32_t randomSeed) : m_engine(randomSeed)
    {
    }

    /// Uniform in low..high.
    btScalar operator()(btScalar low, btScalar high)
    {
        return low + (high - low) * btScalar(double(m_engine()) * 0x1p-32);
    }

  private:
    std::mt19937 m_engine;
};

#endif
