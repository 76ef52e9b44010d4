// Random numbers and vectors, the same in each run.
#ifndef QC_TESTS_BULLET_RANDOM_NUMBERS_H
#define QC_TESTS_BULLET_RANDOM_NUMBERS_H

#include <LinearMath/btVector3.h>

#include <random>

class qcRandomNumbers
{
  public:
    explicit qcRandomNumbers(unsigned start) : m_engine(start)
    {
    }
    btScalar Number(double lowest, double highest)
    {
        return btScalar(std::uniform_real_distribution<double>(lowest, highest)(m_engine));
    }
    btVector3 Vector(double size)
    {
        btScalar x = Number(-size, size), y = Number(-size, size), z = Number(-size, size);
        return btVector3(x, y, z);
    }

  private:
    std::minstd_rand m_engine;
};

#endif
