// A tetrahedron in two.
#include <quickcullide/bullet_fracture.h>

#include <cstdio>

int main()
{
    qcFractureDef def;
    def.vertices = {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1)};
    def.indices = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    def.sites = {btVector3(btScalar(0.1), 0, 0), btVector3(btScalar(0.4), 0, 0)};
    qcFracture fracture = qcFracture_Split(def);
    if (fracture.status != qc_statusOk)
        std::puts(fracture.message.c_str());
    return fracture.pieces.size() == 2 ? 0 : 1;
}
