#version 330 core
// The shadow map has depths only.
void main()
{
}
